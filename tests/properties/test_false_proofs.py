"""Checks that do not hold for all that a file allows: none of them is proved."""

import pytest

from sjdsl.compiler.diagnostics.source import Source
from sjdsl.properties import Effort, GameFamily, verify_properties
from sjdsl.properties.verify_properties import decide_statically

YARD = """sj 1
game yard "Yard" {{
  size  wait : steps = 0 in 0 .. 3
  episode 20
  kind grass "."
  kind tree "T"
  kind door "D" {{ field open : {{ no, yes }} = no  field wide : 0 .. 3 = 1  blocks ray when door.open is no }}
  map {{ "..DT"
        "..DT" }}
  agents 2 {{
    acts turn_left, turn_right, step_left, step_right, forward, backward, stay, zap  moves relative
    field tall : {{ no, yes }} = no
    blocks ray when agent.tall is yes
  }}
  shape ray = line(3)
  phase start {{ each agent {{ send agent to grass facing east }} }}
  schedule tick -> rule
  phase rule {{ {rule} }}
  metrics {{ event opened }}
  checks {{ {checks} }}
}}
"""


def yard(checks: str, rule: str) -> GameFamily:
    """Returns a game in which agents look through doors, with these checks and one rule."""
    return GameFamily(Source("yard.sj", YARD.format(checks=checks, rule=rule), None))


SEEN = "conserved sum(count(tree in ray of agent) over agent)"
UNSEEN = {
    "a door that opens": (SEEN, "each door { set door.open = yes }"),
    "an agent who grows": (SEEN, "each agent where agent chose zap { set agent.tall = yes }"),
    "a door that is widened": (SEEN, "each door { set door.wide = 3 }"),
    "who is away after a delay of another size": ("conserved count(agent)", "each agent { send agent to grass after wait otherwise stay }"),
}


@pytest.mark.parametrize("name", UNSEEN)
def test_what_changes_an_expression_is_seen(name: str) -> None:
    check, rule = UNSEEN[name]
    game = yard(check, rule)
    if name == "a door that is widened":
        game = GameFamily(Source("yard.sj", game.source.text.replace("door.open is no }", "door.wide < 2 }"), None))
    assert decide_statically(game, 0) is None


def test_what_nothing_changes_is_proved() -> None:
    for check, rule in ((SEEN, "each tree { tally opened }"), ("conserved count(agent)", "each door { set door.open = yes }")):
        verdict = decide_statically(yard(check, rule), 0)
        assert verdict is not None
        assert verdict.how == "proved"


def test_a_door_that_opens_is_found_by_play() -> None:
    (verdict,) = verify_properties(
        yard(SEEN, "each agent where agent chose zap { each door { set door.open = yes } }"), Effort(200)
    ).verdicts
    assert verdict.passed is False

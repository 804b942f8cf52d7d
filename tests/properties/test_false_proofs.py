"""Checks that do not hold for all that a file allows: none of them is proved."""

import pytest

from sjdsl.compiler.diagnostics.diagnostic import CompileError
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
    "who is away after a delay of another size": (
        "conserved count(agent)",
        "each agent { send agent to grass after wait otherwise stay }",
    ),
}


@pytest.mark.parametrize("name", UNSEEN)
def test_what_changes_an_expression_is_seen(name: str) -> None:
    check, rule = UNSEEN[name]
    game = yard(check, rule)
    if name == "a door that is widened":
        (source,) = game.composition.sources.values()
        game = GameFamily(
            Source("yard.sj", source.text.replace("door.open is no }", "door.wide < 2 }"), None)
        )
    assert decide_statically(game, 0) is None


def test_what_nothing_changes_is_proved() -> None:
    for check, rule in (
        (SEEN, "each tree { tally opened }"),
        ("conserved count(agent)", "each door { set door.open = yes }"),
    ):
        verdict = decide_statically(yard(check, rule), 0)
        assert verdict is not None
        assert verdict.how == "proved"


def test_a_door_that_opens_is_found_by_play() -> None:
    (verdict,) = verify_properties(
        yard(SEEN, "each agent where agent chose zap { each door { set door.open = yes } }"),
        Effort(200, compiled=False),
    ).verdicts
    assert verdict.passed is False


NUMBERS = """sj 1
game numbers "Numbers" {{
  size  players : count = 3 in 2 .. 6
  size  room : count = 4 in 1 .. 4
  size  free : count = 4
  size  near : count = 1 in 0 .. 4
  size  far : count = near * 2 in 0 .. 4
  size  delta : count = 3 in 3 .. 9
  param share : fraction = 0.5
  param back : fraction = 0.25 in 0.1 .. 1
  param low : count = 2 in 0 .. 9
  param high : count = 5 in 0 .. 9
  param least : count = 2 in 0 .. 9
  param most : count = 5 in 0 .. 9
  param pay : reward = 1
  param tip : reward = 0.1 in 0 .. 0.1
  param rate : reward = 1.1 in 1 .. 1.1
  param huge : count = 1 in 0 .. 100000
  param taste by {{ sour, sweet }} : reward = {{ sour: 0.1, sweet: 0.3 }} in 0.1 .. 0.3
  param loss : reward = -0.1 in -0.1 .. 0.3
  episode 20
  kind grass "."
  map {{ "......" }}
  field pot : 0 .. 9 = 0
  field captain : agent
  field hoard : 0 .. 1000000 capped = 0
  field purse by {{ sour, sweet }} : 0 .. 9 = 0
  agents players {{ acts stay  field seat : 0 .. room = 0 }}
  {more}
  phase start {{ each agent {{ send agent to grass }} }}
  schedule rule
  phase rule {{ when pot < 9 {{ set pot = pot + 1 }} }}
  metrics {{ event hits }}
  checks {{ require low != high  require least < most  {checks} }}
}}
"""


def numbers(checks: str, more: str = "") -> GameFamily:
    """Returns a game of numbers with these checks and declarations."""
    return GameFamily(Source("numbers.sj", NUMBERS.format(checks=checks, more=more), None))


def is_proved(game: GameFamily) -> bool:
    verdict = decide_statically(game, len(game.own.checks) - 1)
    return verdict is not None and verdict.how == "proved"


@pytest.mark.parametrize(
    "check",
    [
        "always share / 0.1 <= 1",
        "always share / back <= 1 or pot > 99",
        "always (0 - share) / (0.5 + share) >= 0",
        "always pot * 0.05 <= 0.45",
        "always pot * 0.1 <= 0.9",
        "always not (pot / 10 > 0.9)",
        "always tip + tip + tip <= 0.3",
        "always (tip + 0.2) - 0.2 >= 0",
        "always pot * 0.1 * 10 <= 9",
        "always pot * rate * 10 <= 99",
        "always taste[sour] * 3 <= 0.9",
        "always sum(taste) <= 0.6",
        "always sum(tip over agent) <= 0.6",
        "always (hoard + 16777216) * 1.0 != 17777217.0 or hoard * 1.0 + 16777216.0 <= 17777215.5",
        "always huge * huge >= 0",
        "always step + 1 > 0",
        "always count(agent) <= 3",
        "always count(agent) * 2 <= 6",
        "always agent_most <= 3",
        "always captain is nobody or captain.index <= 2",
        "always near <= 2",  # with 3 the file's own `far` is refused, and another is not
        "always delta % 3 == 0",
        "always room == 4",
        "always free <= 4",
        "once pot > 3 always count(agent) <= 5",
        "always pay * huge - pay * huge < 1 or pay * huge - pay * huge >= 1",
    ],
)
def test_what_is_false_for_other_numbers_is_not_proved(check: str) -> None:
    more = (
        "define agent_most = max(agent.index over agent otherwise 0)"
        if "agent_most" in check
        else ""
    )
    assert not is_proved(numbers(check, more))


@pytest.mark.parametrize(
    "check",
    [
        "always share / 0.1 >= 0",
        "always share * back <= 1",
        "always share * back * share >= 0",
        "always pot * 0.05 <= 0.46",
        "always pot * 0.5 <= 4.5",
        "always share + back <= 2",
        "always tip <= 0.1 and loss >= -0.1",
        "always taste[sour] <= 0.3 and min(taste) >= 0.1 and max(taste) <= 0.3",
        "always huge * 1000 >= 0",
        "always count(agent) <= 6",
        "always sum(agent.seat over agent) <= 24",
        "always ramp(pot, low, high) <= 1",
        "always 1 / (share + 1) <= 1.001",
        "always loss + 0.1 >= 0",
        "always delta % 3 < 3",
        "always sum(purse) in 0 .. 18",
        "always count(grass where grass.col > 2) / count(grass) <= 1",
        "always round(pot * 0.25) <= 2",
    ],
)
def test_what_holds_for_all_numbers_is_proved(check: str) -> None:
    assert is_proved(numbers(check))


@pytest.mark.parametrize(
    ("value", "proved"),
    [
        ("ramp(pot, low, high)", ""),
        ("ramp(pot, least, most)", "rising"),
        ("ramp(pot, most, least)", "falling"),
        ("ramp(share * pot, 0.5, 0.25)", "falling"),
        ("pot / (0 - 2)", "falling"),
        ("share / (0 - 0.1) * pot", "falling"),
        ("pot / (share - 0.5)", ""),
        ("pot / (share - 2)", "falling"),
        ("pot * loss", ""),
        ("pot * (delta - 6)", ""),
        ("pot * (delta - 2)", "rising"),
        ("pot * huge * huge", ""),
        ("pot * 1000", "rising"),
        ("round(pot * 0.5) - round(pot / (0 - 2))", "rising"),
        ("round(pot * loss)", ""),
    ],
)
def test_which_slopes_are_proved(value: str, proved: str) -> None:
    more = f"define value = {value}  define argument = pot"
    try:
        found = [
            way
            for way in ("rising", "falling")
            if is_proved(numbers(f"monotone value {way} in argument", more))
        ]
    except CompileError as error:
        found = [] if {d.code for d in error.diagnostics} == {"SJ207"} else ["refused"]
    assert found == ([proved] if proved else [])


MEET = """sj 1
game meet "Meet" {{
  size  players : count = {players}
  param gift by agent : reward = {{ 0: 1, otherwise: 2 }} in 0 .. 3
  param odds : reward = {{ shy: {{ shy: 1, bold: 2 }}, bold: {{ shy: 3, bold: 4 }} }}
  param share by {{ shy, bold }} : reward = 1
  episode 20
  kind grass "."
  map {{ "....." "....." "....." }}
  agents players {{
    acts turn_left, turn_right, step_left, step_right, forward, backward, stay, zap  moves relative
    field mood : {{ shy, bold }} = shy
  }}
  field purse by agent : reward = 0
  shape round = square(1)
  shape ahead = line(2)
  phase start {{ {start} }}
  schedule rule
  phase rule {{ {rule} }}
  metrics {{ event met }}
  checks {{ symmetric agents }}
}}
"""
PLACED = "each agent { send agent to grass }"


def meet(rule: str, players: str = "3", start: str = PLACED) -> GameFamily:
    """Returns a game of agents who meet, with one rule, and their symmetry as its check."""
    return GameFamily(Source("meet.sj", MEET.format(rule=rule, players=players, start=start), None))


PAIR = "match agent as a with first agent as b in round of a { give 1 to b }"


@pytest.mark.parametrize(
    ("rule", "even"),
    [
        (PAIR, True),
        ("set purse = gift", False),
        ("each agent { give sum(gift) to agent }", False),
        ("each agent { give gift[agent] to agent }", False),
        ("each agent as a { each agent as b { give gift[b] to a } }", False),
        ("each agent { give share[agent.mood] to agent }", True),
        ("each agent where agent.index == 0 { give 1 to agent }", False),
        (
            "each agent as a { send a to grass where distance(grass, a) < 2 otherwise stay }",
            False,
        ),
        ("each agent { send agent to grass otherwise stay }", True),
    ],
)
def test_which_symmetries_are_proved(rule: str, even: bool) -> None:
    assert is_proved(meet(rule)) is even


def test_one_agent_proves_nothing_about_several() -> None:
    assert not is_proved(
        meet("each agent where agent.index == 0 { give 1 to agent }", "1 in 1 .. 3")
    )


def test_a_rule_that_reads_a_table_by_agent_fails_with_its_line() -> None:
    verdict = decide_statically(meet("each agent { give gift[agent] to agent }"), 0)
    assert verdict is not None
    assert (verdict.passed, verdict.reason) == (False, "line 19 reads `gift`, a table by agent")


def test_a_verdict_says_what_it_leaves_out() -> None:
    start = "each agent { send agent to grass facing north }  each agent where agent.index == 0 { set agent.mood = bold }"
    said = decide_statically(meet("", start=start), 0)
    assert said is not None
    assert (
        said.reason
        == "no rule of a step reads an agent's number; `phase start` does, in line 17, and is not part of this"
    )
    said = decide_statically(
        meet(
            "each agent as a { send a to grass where distance(grass, a) < 2 otherwise stay }",
        ),
        0,
    )
    assert said is not None
    assert said.how == "decided"
    assert "in line 19 some cells suit only some agents" in said.reason

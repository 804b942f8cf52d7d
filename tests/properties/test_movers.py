"""Checks of games with movers: what is proved of them, and what play finds."""

import pytest

from sjdsl.compiler.diagnostics.source import Source
from sjdsl.interpreter import movement, step
from sjdsl.properties import Effort, GameFamily, verify_properties
from sjdsl.properties.verify_properties import decide_statically

HERD = """sj 1
game herd "Herd" {{
  param prize : reward = 1
  episode 20
  kind grass "." {{ field grown : {{ lush, bare }} = lush }}
  kind pond  "~" {{ blocks agents, deer }}
  map {{ "..~" "..." }}
  agents 2 {{
    acts turn_left, turn_right, forward, stay, shoot
    moves relative
  }}
  movers deer 2 "d" {{ field fear : {{ calm, scared }} = calm  timer rest  field hits : 0 .. 9 capped = 0 }}
  movers duck 1 "q"
  shape ray = line(2)
  phase start {{
    each agent {{ send agent to grass }}
    each deer {{ send deer to grass }}
    each duck {{ send duck to pond }}
  }}
  schedule tick -> walk -> roam -> rule
  phase walk {{ move each agent }}
  phase roam {{ {roam} }}
  phase rule {{ {rule} }}
  metrics {{ event hits }}
  checks {{ {checks} }}
}}
"""
SCARE = "each agent as a where a chose shoot { first deer in ray of a { set deer.fear = scared  set deer.rest = 3  tally hits for a } }"
ROAM = "move each deer at random"


def herd(checks: str, rule: str = SCARE, roam: str = ROAM, text: str = HERD) -> GameFamily:
    """Returns a small herd with these checks, and with other rules."""
    return GameFamily(Source("herd.sj", text.format(checks=checks, rule=rule, roam=roam), None))


PROVED = [
    "conserved count(deer)",
    "conserved count(duck)",
    "symmetric agents",
    "symmetric deer",
    "symmetric duck",
]


def test_what_no_rule_changes_is_proved() -> None:
    family = herd("  ".join(PROVED))
    assert all(
        (v := decide_statically(family, i)) is not None and v.passed for i in range(len(PROVED))
    )


WRITTEN = {  # check -> a rule that breaks it, for which nothing may be proved
    "conserved count(deer)": "each deer where deer.fear is scared { remove deer }" + SCARE,
    "conserved count(deer where deer.heading is north)": SCARE,
    "conserved sum(deer.rest over deer)": SCARE,
    "conserved count(deer where deer.moved)": SCARE,
    "conserved sum(min(distance(deer, agent) over agent otherwise 0) over deer)": SCARE,
    "always count(deer where deer.fear is scared) == 0": SCARE,
    "always count(deer) + count(duck) == 3": "each duck { chance 0.5 { send duck to pond after 3 otherwise stay } }",
}


@pytest.mark.parametrize("check", WRITTEN)
def test_what_a_rule_changes_is_refuted_and_shown(check: str) -> None:
    report = verify_properties(herd(check, WRITTEN[check]), Effort(examples=60, compiled=False))
    (verdict,) = report.verdicts
    assert verdict.passed is False
    assert any("deer" in line or "duck" in line for line in verdict.trace)


def test_a_rule_that_reads_the_number_of_a_mover_fails() -> None:
    rule = "each deer where deer.index == 0 { set deer.fear = scared }"
    for what, passes in (("deer", False), ("duck", True), ("agents", True)):
        verdict = decide_statically(herd(f"symmetric {what}", rule), 0)
        assert verdict is not None
        assert verdict.passed is passes
        assert passes or verdict.reason.endswith("reads `deer.index`")


def test_two_movers_on_one_cell_are_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """With an interpreter that lets two of a herd enter one cell, a count of the cells that are taken falls behind."""
    monkeypatch.setattr(movement, "stay_if_outranked", lambda *_: None)
    monkeypatch.setattr(step, "_check_places", lambda *_: None)
    check = "always count(grass where not nobody on grass) + count(pond where not nobody on pond) == count(agent) + count(deer) + count(duck)"
    (verdict,) = verify_properties(herd(check), Effort(compiled=False)).verdicts
    assert verdict.passed is False
    monkeypatch.undo()
    (verdict,) = verify_properties(herd(check), Effort(examples=10, compiled=False)).verdicts
    assert verdict.passed


@pytest.mark.parametrize("seeker", ["seek deer", "seek deer where deer.fear is calm"])
def test_policies_seek_movers(seeker: str) -> None:
    """A seeker stands beside a deer at the end; the deer stay where they are."""
    family = herd(
        f"expect count(agent where count(deer in disc(1) of agent) > 0) > 0 with {seeker} over 2 episodes",
        "",
        "",
    )
    (verdict,) = verify_properties(family).verdicts
    assert verdict.passed, verdict.reason

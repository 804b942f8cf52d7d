"""Checks of games with movers: what is proved of them, what play finds, and where they stand on random maps."""

from random import Random

import pytest

from sjdsl.compiler.diagnostics.source import Source
from sjdsl.interpreter import movement, step
from sjdsl.interpreter.board import board_of
from sjdsl.properties import Effort, GameFamily, verify_properties
from sjdsl.properties.random_starts import random_start
from sjdsl.properties.symmetry import transformed_games
from sjdsl.properties.trajectory import play
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


PROVED = ["conserved count(deer)", "conserved count(duck)", "symmetric agents", "symmetric mirror", "symmetric deer", "symmetric duck"]


def test_what_no_rule_changes_is_proved() -> None:
    family = herd("  ".join(PROVED))
    assert all((v := decide_statically(family, i)) is not None and v.passed for i in range(len(PROVED)))


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
    report = verify_properties(herd(check, WRITTEN[check]), Effort(examples=30, episodes=0, tries=60))
    (verdict,) = report.verdicts
    assert verdict.passed is False
    assert any("deer" in line or "duck" in line for line in verdict.trace)


UNEVEN = {  # symmetry -> rules under which it does not hold
    "deer": ["each deer where deer.index == 0 { set deer.fear = scared }"],
    "mirror": [
        "each deer where deer.heading is east { set deer.fear = scared }",
        "each deer { set deer.heading = west }",
        "each deer { send deer by 1 east otherwise stay }",
        "each deer where deer.col == 0 { add 1 to deer.hits }",
        "each deer { send deer to grass facing east otherwise stay }",
    ],
}


@pytest.mark.parametrize(("what", "rule"), [(what, rule) for what, rules in UNEVEN.items() for rule in rules])
def test_uneven_rules_are_found(what: str, rule: str) -> None:
    (verdict,) = verify_properties(herd(f"symmetric {what}", rule), Effort(examples=30, episodes=0, tries=20)).verdicts
    assert verdict.passed is False
    assert "would give something else" in "\n".join(verdict.trace)
    others = ({"agents", "deer", "mirror"} - {what}) - ({"deer"} if "col" in rule else set())
    for other in others:
        even = decide_statically(herd(f"symmetric {other}", rule), 0)
        assert even is not None, other
        assert even.passed


@pytest.mark.parametrize("way", ["ahead", "toward agent avoiding pond", "at random"])
def test_ways_of_movers_have_mirror_images(way: str) -> None:
    """Proved, and played, for with a rule that tells left from right nothing is proved."""
    family = herd("symmetric mirror", roam=f"move each deer {way}")
    assert decide_statically(family, 0) is not None
    rule = SCARE + " each agent as a where a chose turn_left or a chose turn_right { give 1 to a }"
    played = herd("symmetric mirror", rule, f"move each deer {way}")
    assert transformed_games(played.own.checks[0], played.own)
    (verdict,) = verify_properties(played, Effort(examples=12, episodes=0)).verdicts
    assert verdict.passed


def test_a_way_to_the_east_has_no_mirror_image() -> None:
    (verdict,) = verify_properties(herd("symmetric mirror", roam="move each deer along east"), Effort(examples=20, tries=20)).verdicts
    assert verdict.passed is False


def test_a_mover_that_turns_as_a_hunter_looks_has_a_mirror_image() -> None:
    rule = "pick 1 agent as a where a chose shoot { pick 1 deer in ray of a { set deer.heading = a.heading } }"
    (verdict,) = verify_properties(herd("symmetric mirror", rule), Effort(examples=12, episodes=0)).verdicts
    assert verdict.passed


def test_random_maps_have_room_for_every_mover() -> None:
    """Most random maps are taken, and on each every deer and duck begins on a cell that it may be sent to."""
    family, random = herd("conserved count(deer)"), Random(3)
    starts = [random_start(family, random) for _ in range(40)]
    taken = [start for start in starts if start is not None]
    assert len(taken) >= 36
    for start in taken:
        game = family.on(start.rows, start.agents)
        assert game is not None
        world, board = play(game, start, 0).worlds[0], board_of(game)
        for sort, kind in (("deer", "grass"), ("duck", "pond")):
            assert [board.kind_of[cell] for cell in world.movers[sort].position if cell is not None] == [kind] * (
                2 if sort == "deer" else 1
            )


def test_two_movers_on_one_cell_are_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """With an interpreter that lets two of a herd enter one cell, a count of the cells that are taken falls behind."""
    monkeypatch.setattr(movement, "stay_if_outranked", lambda *_: None)
    monkeypatch.setattr(step, "_check_places", lambda *_: None)
    check = (
        "always count(grass where not nobody on grass) + count(pond where not nobody on pond) == count(agent) + count(deer) + count(duck)"
    )
    (verdict,) = verify_properties(herd(check), Effort(episodes=0, tries=60)).verdicts
    assert verdict.passed is False
    monkeypatch.undo()
    (verdict,) = verify_properties(herd(check), Effort(examples=10, episodes=0)).verdicts
    assert verdict.passed


@pytest.mark.parametrize("seeker", ["seek deer", "seek deer where deer.fear is calm"])
def test_policies_seek_movers(seeker: str) -> None:
    """A seeker stands beside a deer at the end; the deer stay where they are."""
    family = herd(f"expect count(agent where count(deer in disc(1) of agent) > 0) > 0 with {seeker} over 2 episodes", "", "")
    (verdict,) = verify_properties(family).verdicts
    assert verdict.passed, verdict.reason

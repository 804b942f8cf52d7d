"""A verdict is about the game's own map: what fails on other maps only is a note, what fails on both is found on both."""

import re

import pytest

from sjdsl.compiler.diagnostics.source import Source
from sjdsl.properties import Effort, GameFamily, Verdict, verify_properties

from .small_games import ORCHARD, small_game

EFFORT = Effort(examples=60, episodes=2, tries=60)
MARKET = """sj 1
game market "A market with four stalls, three goods on each"
{
  episode 80
  kind street "."
  kind stall "S" { field stock : 0 .. 3 = 3 }
  map { "S....S"
        "......"
        "S....S" }
  field sold : 0 .. 100 capped = 0
  agents 3 { acts turn_left, turn_right, step_left, step_right, forward, backward, stay, buy  moves relative }
  phase start { each agent { send agent to street } }
  schedule walk -> buy
  phase walk { move each agent }
  phase buy { each agent on stall where agent chose buy and stall.stock > 0 { add -1 to stall.stock  add 1 to sold } }
  checks { CHECK }
}
"""
DOORS = """sj 1
game doors "Whoever stands on both plates opens the door for a third"
{
  episode 60
  kind floor "."
  kind wall "#" { blocks agents }
  kind plate "o"
  kind door "D" { field open : { no, yes } = no  blocks agents when door.open is no }
  kind room "x"
  map { "...#x"
        ".o.Dx"
        "..o#x"
        "...#x" }
  agents 3 { acts turn_left, turn_right, step_left, step_right, forward, backward, stay  moves relative }
  phase start { each agent { send agent to floor } }
  schedule walk -> doors
  phase walk { move each agent }
  phase doors { each door { when count(agent on plate) == 2 { set door.open = yes } otherwise { set door.open = no } } }
  checks { CHECK }
}
"""
LIFT = """sj 1
game lift "A lift stops at the row of one of four doors"
{
  size one : cells = 1
  size top : cells = 3
  episode 80
  kind hall "."
  kind door "D" { field open : { no, yes } = no  glyph "d" with open = yes }
  map { "D....." "D....." "D....." "d....." "......" }
  field level : 0 .. top = top
  agents 2 { acts turn_left, turn_right, forward, stay, up, down  moves relative }
  phase start { each agent { send agent to hall } }
  schedule walk -> call -> doors
  phase walk { move each agent }
  phase call {
    when count(agent where agent chose up) == 2 and level >= one { set level = level - one }
    otherwise when count(agent where agent chose down) == 2 and level <= top - one { set level = level + one }
  }
  phase doors { each door { when door.row == level { set door.open = yes } otherwise { set door.open = no } } }
  checks { CHECK }
}
"""
RAFT = """sj 1
game raft "A raft along a rope; it is where it is on the rope"
{
  size one : cells = 1
  episode 60
  kind bank "."
  kind water "~" { field raft : { no, yes } = no  glyph "r" with raft = yes  blocks agents }
  map { "....." "~~r~~" "....." }
  field at : 0 .. 4 * one = 2 * one
  agents 2 { acts turn_left, turn_right, forward, stay, pull, push  moves relative }
  phase start { each agent { send agent to bank } }
  schedule walk -> haul -> drift
  phase walk { move each agent }
  phase haul {
    when count(agent where agent chose pull) > 0 and at <= LAST * one { set at = at + one }
    otherwise when count(agent where agent chose push) > 0 and at >= one { set at = at - one }
  }
  phase drift { each water { when water.col == at { set water.raft = yes } otherwise { set water.raft = no } } }
  checks { CHECK }
}
"""


def verdict_on(text: str, check: str, effort: Effort = EFFORT) -> Verdict:
    (verdict,) = verify_properties(GameFamily(Source("game.sj", text.replace("CHECK", check), None)), effort).verdicts
    return verdict


NEEDS_ITS_MAP = [
    (MARKET, "always sold <= 12"),  # four stalls
    (MARKET, "always sum(stall.stock over stall) <= 12"),
    (DOORS, "always count(agent on plate) <= 2"),  # two plates
    (DOORS, "always count(agent on room) <= 1"),  # of three agents two must stay on the plates
]


@pytest.mark.thorough
@pytest.mark.parametrize(("game", "check"), NEEDS_ITS_MAP)
def test_what_fails_on_another_map_only_is_a_note(game: str, check: str) -> None:
    verdict = verdict_on(game, check, Effort(examples=400, episodes=2, tries=20))
    assert verdict.passed
    assert re.fullmatch(r"[0-9]+ trajectories on small maps, [0-9,]+ steps on the game's own map", verdict.reason)
    assert verdict.note is not None
    assert verdict.note.passed is False
    assert verdict.note.scenario is not None
    assert verdict.note.trace[0].split(" agent")[1].endswith("on a small map")


@pytest.mark.parametrize(("game", "check"), NEEDS_ITS_MAP)
def test_it_is_an_error_if_any_map_will_do(game: str, check: str) -> None:
    verdict = verdict_on(game, check, Effort(examples=400, episodes=0, tries=0, any_map=True))
    assert verdict.passed is False
    assert verdict.note is None


def on_own_map(verdict: Verdict, text: str) -> bool:
    rows = GameFamily(Source("game.sj", text.replace("CHECK", "require 1 > 0"), None)).own.rows
    return verdict.scenario is not None and verdict.scenario.rows == rows


@pytest.mark.parametrize(
    ("game", "check"),
    [
        (MARKET, "always sold < 9"),
        (DOORS, "always count(agent on room) == 0"),
        (LIFT, "always level > one"),
        (RAFT.replace("LAST", "3"), "always at <= 3 * one"),
    ],
)
def test_what_fails_on_the_own_map_too_is_shown_there(game: str, check: str) -> None:
    verdict = verdict_on(game, check, Effort(examples=200, episodes=0, tries=20))
    assert verdict.passed is False
    assert on_own_map(verdict, game)
    assert "on the game's own map" in verdict.trace[0]


@pytest.mark.parametrize(
    ("game", "check", "passes"),
    [
        (LIFT, "always count(door where door.open is yes) == 1", True),
        (RAFT.replace("LAST", "3"), "conserved count(water where water.raft is yes)", True),
        (RAFT.replace("LAST", "3").replace("~~r~~", "~~r~."), "conserved count(water where water.raft is yes)", False),  # a bank at its end
    ],
)
def test_a_game_that_reads_rows_or_columns_is_judged_on_its_map(game: str, check: str, passes: bool) -> None:
    verdict = verdict_on(game, check)
    assert verdict.passed is passes
    assert verdict.note is None
    assert passes or on_own_map(verdict, game)


def test_more_agents_than_the_file_has_are_played_if_it_allows_them() -> None:
    """The file has two agents and allows four."""
    rule, more = "set busy = count(agent where agent chose zap)", "field busy : 0 .. 9 = 0"
    for limit, passes in (("1 .. 4", False), ("1 .. 2", True)):
        text = ORCHARD.replace("1 .. 4", limit)
        (verdict,) = verify_properties(small_game("always busy < 3", rule, more, text), Effort(examples=100, episodes=0, seed=1)).verdicts
        assert verdict.how == "examples"
        assert verdict.passed is passes
        assert passes or (verdict.scenario is not None and verdict.scenario.agents == 3)


def test_a_real_that_leaves_float32_on_another_map_only_is_a_note() -> None:
    """Doubled for each tree of the map: 2 on its own; a small map can have three."""
    rule = "each agent where count(tree) > 2 { set rich = rich * 1000000000 * 1000000000 }"
    family = small_game("always zaps < 999", rule, "field rich : reward = 1")
    report = verify_properties(family, Effort(examples=60, episodes=0, tries=20))
    assert report.faults == ()
    (note,) = report.notes
    assert "leaves float32" in note.reason
    assert verify_properties(family, Effort(examples=60, episodes=0, tries=20, any_map=True)).faults


RARE = "each agent where agent.wealth == 2 and agent chose zap and agent.heading is north { tally zaps for agent }"
SHORT = ORCHARD.replace("episode 20", "episode 6")


def test_a_line_that_no_episode_of_random_play_reaches_makes_an_expectation_untested() -> None:
    (verdict,) = verify_properties(small_game("expect zaps == 0 with random over 2 episodes", RARE, text=SHORT), EFFORT).verdicts
    assert verdict.status == "untested"
    assert verdict.untested == ("orchard.sj:29  tally zaps for agent  (in none of its own episodes)",)


def test_episodes_of_other_policies_say_what_they_did_not_reach() -> None:
    expects = "expect zaps == 0 with never(zap) over 2 episodes"
    (verdict,) = verify_properties(small_game(expects, RARE, text=SHORT), EFFORT).verdicts
    assert verdict.status == "passed"
    assert "orchard.sj:29  tally zaps for agent" in verdict.unreached


@pytest.mark.thorough
def test_sizes_that_the_file_allows_are_played() -> None:
    more = "size most : count = 2 in 1 .. 5  size fixed : count = 2  field busy : 0 .. 9 = 0"
    rule = "set busy = min(busy + count(agent where agent chose zap), most)"
    for check, passes in (("always busy <= 2", False), ("always busy <= most", True)):
        family = small_game(check, rule, more)
        assert [size.name for size in family.free_sizes] == ["most"]
        (verdict,) = verify_properties(family, Effort(examples=300, episodes=0, tries=60)).verdicts
        assert verdict.passed is passes
        assert passes or (verdict.scenario is not None and dict(verdict.scenario.sizes)["most"] in (3, 5))
        assert passes or "(the file: 2)" in verdict.trace[0]

"""A verdict is about the game's own map: what fails on other maps only passes, what fails there is found."""

import pytest

from sjdsl.compiler.diagnostics.source import Source
from sjdsl.properties import Effort, GameFamily, Verdict, verify_properties

EFFORT = Effort(examples=60)
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
    (verdict,) = verify_properties(
        GameFamily(Source("game.sj", text.replace("CHECK", check), None)), effort
    ).verdicts
    return verdict


NEEDS_ITS_MAP = [
    (MARKET, "always sold <= 12"),  # four stalls
    (MARKET, "always sum(stall.stock over stall) <= 12"),
    (DOORS, "always count(agent on plate) <= 2"),  # two plates
    (DOORS, "always count(agent on room) <= 1"),  # of three agents two must stay on the plates
]


@pytest.mark.thorough
@pytest.mark.parametrize(("game", "check"), NEEDS_ITS_MAP)
def test_what_fails_on_other_maps_only_passes(game: str, check: str) -> None:
    assert verdict_on(game, check).passed


@pytest.mark.parametrize(
    ("game", "check"),
    [
        (MARKET, "always sold < 9"),
        (DOORS, "always count(agent on room) == 0"),
        (LIFT, "always level > one"),
        (RAFT.replace("LAST", "3"), "always at <= 3 * one"),
    ],
)
def test_what_fails_on_the_own_map_is_found(game: str, check: str) -> None:
    assert verdict_on(game, check).passed is False


@pytest.mark.parametrize(
    ("game", "check", "passes"),
    [
        pytest.param(
            LIFT,
            "always count(door where door.open is yes) == 1",
            True,
            marks=pytest.mark.thorough,
        ),
        pytest.param(
            RAFT.replace("LAST", "3"),
            "conserved count(water where water.raft is yes)",
            True,
            marks=pytest.mark.thorough,
        ),
        (
            RAFT.replace("LAST", "3").replace("~~r~~", "~~r~."),
            "conserved count(water where water.raft is yes)",
            False,
        ),  # a bank at its end
    ],
)
def test_a_game_that_reads_rows_or_columns_is_judged_on_its_map(
    game: str, check: str, passes: bool
) -> None:
    assert verdict_on(game, check).passed is passes

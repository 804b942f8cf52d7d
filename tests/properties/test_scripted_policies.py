"""Checks whose agents follow policies of the file: what does not hold under them is found."""

import pytest

from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.properties import GameFamily, verify_properties

from .small_games import ORCHARD, small_game

POLICIES = """policy eater { seek tree where tree.fruit is ripe }
  policy shooter { when agent.tired > 0 choose turn_left  aim ray at agent as other where other is not agent choose zap }
  policy faster { seek tree avoiding grass where grass.row == 1 }"""
CHECKS = """expect eaten > 0 with eater over 3 episodes
  expect zaps > 3 with shooter, never(zap) over 3 episodes
  expect eaten == 0 with eater, shooter over 3 episodes
  expect zaps == 0 with faster, random, seek tree over 3 episodes"""
TALLY = "each agent where agent chose zap { set agent.tired = 2  tally zaps for agent }"


@pytest.fixture(scope="module")
def orchard() -> GameFamily:
    text = ORCHARD.replace('"..T" ".T."', '"...T" ".#.." "T..."').replace(
        "count = 2 in", "count = 3 in"
    )
    return small_game(CHECKS, TALLY, POLICIES, text=text)


def test_what_does_not_hold_under_them_is_found(orchard: GameFamily) -> None:
    verdicts = verify_properties(orchard).verdicts
    assert [verdict.passed for verdict in verdicts] == [True, True, False, False]
    assert "episode 0, with eater, shooter" in verdicts[2].trace[0]


def test_a_policy_that_is_not_there_is_refused() -> None:
    with pytest.raises(CompileError, match="eater"):
        small_game("expect eaten > 0 with eaters over 2 episodes", TALLY, POLICIES)

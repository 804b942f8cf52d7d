"""Planted faults are found, and the games without them are not refuted; with which seeds is in docs/proof.md."""

import pytest

from sjdsl.properties import Effort, verify_properties

from .planted_faults import FAULTS, GAMES, RULES, look_for, planted

QUICK = (  # all but the last two are found before the game is compiled
    "gate",
    "lock",
    "raft",
    "one chance in 2,000",
    "two rare chances, one after the other",
    "a rare chance for agents that act on a plate",
    "all six chances at once",
    "four chances in a row",
    "three press red",
    "red, green and blue in one step",
    "four tiles visited in the last step",
    "a chance that is certain",
    "low above high when two press blue",
    "a reward at its maximum for agents that act on a plate",
    "red in the last step",
)
MISSED = ("as many agents as allowed press red",)  # the file has three agents


def test_there_are_forty_two() -> None:
    assert (len(GAMES), len(RULES)) == (12, 30)


@pytest.mark.parametrize(
    "name",
    [
        name if name in QUICK else pytest.param(name, marks=pytest.mark.thorough)
        for name in FAULTS
        if name not in MISSED
    ],
)
def test_a_fault_is_found(name: str) -> None:
    (verdict,) = look_for(name, Effort()).verdicts
    assert verdict.passed is False
    assert verdict.scenario is not None


@pytest.mark.parametrize("game", GAMES)
def test_the_game_without_it_is_not_refuted(game: str) -> None:
    report = verify_properties(planted(game, None), Effort(examples=10, compiled=False))
    assert [v.text for v in report.verdicts if not v.passed] == []
    assert not report.faults

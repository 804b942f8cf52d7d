"""Planted faults are found on the game's own map, and the games without them are not refuted; with which seeds is in docs/proof.md."""

import pytest

from sjdsl.properties import Effort, verify_properties

from .planted_faults import FAULTS, GAMES, RULES, faulty, look_for, planted

QUICK = (  # most are found before the game is compiled
    "gate",
    "raft",
    "one chance in 2,000",
    "two rare chances, one after the other",
    "a rare chance of who acts on a plate",
    "all six chances at once",
    "four chances in a row",
    "red, green and blue in one step",
    "five reds, then three greens",
    "red in the last step",
)
MISSED = ("as many agents as allowed press red",)  # the file has three agents


def test_there_are_forty_two() -> None:
    assert (len(GAMES), len(RULES)) == (12, 30)


@pytest.mark.parametrize(
    "name", [name if name in QUICK else pytest.param(name, marks=pytest.mark.thorough) for name in FAULTS if name not in MISSED]
)
def test_a_fault_is_found_on_the_own_map(name: str) -> None:
    (verdict,) = look_for(name, Effort(tries=0)).verdicts
    assert verdict.passed is False
    assert verdict.note is None
    assert verdict.scenario is not None
    assert verdict.scenario.rows == faulty(name).own.rows


@pytest.mark.parametrize("game", GAMES)
def test_the_game_without_it_is_not_refuted(game: str) -> None:
    report = verify_properties(planted(game, None), Effort(examples=10, episodes=0))
    assert [v.text for v in report.verdicts if not v.passed] == []
    assert not report.faults

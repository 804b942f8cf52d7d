"""Agents with other numbers, and all they are and have with them, get each what they got before.

Left out by the manual: who stays when free cells run out (`otherwise stay`: lower numbers first).
"""

from pathlib import Path

import pytest

from sjdsl.compiler import build
from sjdsl.compiler.syntax.read import read_source
from tests.laws.corpus import FEW, SOME_OF_NINE, game_of, random_games
from tests.laws.obeyed import trials
from tests.laws.symmetry import renamed

GAMES = Path(__file__).parents[1] / "differential"


@pytest.mark.parametrize("name", SOME_OF_NINE)
def test_nine_games(name: str) -> None:
    tried = trials([(name, game_of(name))], renamed, steps=5, compiled=True)
    assert not tried.fault
    assert tried.steps >= 4


def test_random_programs() -> None:
    tried = trials(random_games(FEW), renamed, steps=6, compiled=True)
    assert not tried.fault
    assert tried.steps > 4 * FEW
    assert tried.drawn > 40 * FEW


@pytest.mark.parametrize(
    ("game", "plays"),
    [
        ("on_numpy/lots", 4),  # who of several wins a lot depends on what they drew
        ("games/movers", 2),  # agents and movers of each sort: which deer is caught, and by whom
    ],
)
def test_no_number_decides(game: str, plays: int) -> None:
    game_ = build(read_source(GAMES / f"{game}.sj")).game
    tried = trials([(number, game_) for number in range(plays)], renamed, steps=5, compiled=True)
    assert not tried.fault
    assert tried.steps >= 4 * plays - 1

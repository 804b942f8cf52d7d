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


def test_lots() -> None:
    """Who of several wins a lot depends on what they drew, not on their numbers."""
    game = build(read_source(GAMES / "on_numpy" / "lots.sj")).game
    tried = trials([(number, game) for number in range(4)], renamed, steps=5, compiled=True)
    assert not tried.fault
    assert tried.steps >= 15


def test_movers() -> None:
    """Agents and movers of each sort with other numbers: which deer is caught, and by whom, is the same."""
    game = build(read_source(GAMES / "games" / "movers.sj")).game
    tried = trials([(number, game) for number in range(2)], renamed, steps=5, compiled=True)
    assert not tried.fault
    assert tried.steps >= 7

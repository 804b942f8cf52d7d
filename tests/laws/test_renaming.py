"""Agents with other numbers, and all they are and have with them, get each what they got before.

Left out by the manual: who stays when free cells run out (`otherwise stay`: lower numbers first).
"""

import pytest

from tests.games.environments import NINE
from tests.laws.corpus import FEW, game_of, random_games
from tests.laws.obeyed import trials
from tests.laws.symmetry import renamed


@pytest.mark.parametrize("name", NINE)
def test_nine_games(name: str) -> None:
    tried = trials([(name, game_of(name))], renamed, steps=5, compiled=True)
    assert not tried.fault
    assert tried.steps >= 4


def test_random_programs() -> None:
    tried = trials(random_games(FEW), renamed, steps=6, compiled=True)
    assert not tried.fault
    assert tried.steps > 4 * FEW
    assert tried.drawn > 40 * FEW

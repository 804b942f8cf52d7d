"""A chance of 1 equals the rule without its chance: as a number, and as a parameter, which is drawn for."""

from random import Random

import pytest

from tests.laws.corpus import FEW, SOME_OF_NINE, game_of, random_games
from tests.laws.extremes import first_parting


@pytest.mark.parametrize("name", SOME_OF_NINE)
def test_nine_games(name: str) -> None:
    found, tried = first_parting(game_of(name), 1, Random(name))
    assert not found
    assert tried


def test_random_programs() -> None:
    branches = 0
    for seed, game in random_games(FEW):
        found, tried = first_parting(game, 1, Random(seed), most=1)
        assert not found, (seed, found)
        branches += tried
    assert branches >= FEW // 2

"""A map, shapes, turns and headings mirrored or turned by 90 degrees: the play is mirrored and turned with them."""

from collections.abc import Callable
from random import Random

import pytest

from sjdsl.compiler import ir
from tests.games.environments import NINE
from tests.laws.corpus import FEW, game_of, random_games
from tests.laws.obeyed import trials
from tests.laws.symmetry import Symmetry, turns


def mirrored(game: ir.Game, _: Random) -> Symmetry:
    return next(s for s in turns(game) if s.mirror and s.quarters == 0)


def turned(game: ir.Game, _: Random) -> Symmetry:
    return next(s for s in turns(game) if not s.mirror and s.quarters == 1)


def any_turn(game: ir.Game, random: Random) -> Symmetry:
    return random.choice(list(turns(game)))


@pytest.mark.parametrize("look", [mirrored, turned])  # all others are made of these two
@pytest.mark.parametrize("name", NINE)
def test_nine_games(name: str, look: Callable[[ir.Game, Random], Symmetry]) -> None:
    tried = trials([(name, game_of(name))], look, steps=4, compiled=True)
    assert not tried.fault
    assert tried.steps >= 3


def test_random_programs() -> None:
    tried = trials(random_games(FEW), any_turn, steps=6, compiled=True)
    assert not tried.fault
    assert tried.steps > 4 * FEW
    assert tried.drawn > 40 * FEW

"""A map, shapes, turns and headings mirrored or turned by 90 degrees: the play is mirrored and turned with them."""

from collections.abc import Callable
from pathlib import Path
from random import Random

import pytest

from sjdsl.compiler import build, ir
from sjdsl.compiler.syntax.read import read_source
from tests.games.environments import NINE
from tests.laws.corpus import FEW, game_of, random_games
from tests.laws.obeyed import trials
from tests.laws.symmetry import Symmetry, turns

TESTS = Path(__file__).parents[1]


def mirrored(game: ir.Game, _: Random) -> Symmetry:
    return next(s for s in turns(game) if s.mirror and s.quarters == 0)


def turned(game: ir.Game, _: Random) -> Symmetry:
    return next(s for s in turns(game) if not s.mirror and s.quarters == 1)


def any_turn(game: ir.Game, random: Random) -> Symmetry:
    return random.choice(list(turns(game)))


@pytest.mark.thorough
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


PUSHING = ("pushing", "own_destinations", "cells")


@pytest.mark.parametrize(
    ("game", "plays", "steps", "compiled", "least"),
    [
        # movers that flee, hunt, roll, ride and drift do so to the other side, and what they draw among cells turns with the map
        ("differential/games/movers", 2, 6, True, 10),
        # whom a rule turns or sends with a computed heading; and phases with which an episode begins
        ("cases/headings", 3, 8, False, 10),
        # pushes, also where two directions are equally far; destinations that depend on who is sent
        *((f"differential/games/{name}", 4, 10, False, 20) for name in PUSHING),
    ],
)
def test_what_turns_with_the_map(
    game: str, plays: int, steps: int, compiled: bool, least: int
) -> None:
    game_ = build(read_source(TESTS / f"{game}.sj")).game
    played = [(number, game_) for number in range(plays)]
    tried = trials(played, any_turn, steps=steps, compiled=compiled)
    assert not tried.fault
    assert tried.steps >= least

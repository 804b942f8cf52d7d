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

CASES = Path(__file__).parents[1] / "cases"
SENDS = Path(__file__).parents[1] / "differential" / "games"


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


def test_movers() -> None:
    """Movers that flee, hunt, roll, ride and drift do so to the other side; what they draw among cells beside them turns with the map."""
    game = build(read_source(SENDS / "movers.sj")).game
    tried = trials([(name, game) for name in range(2)], any_turn, steps=6, compiled=True)
    assert not tried.fault
    assert tried.steps >= 10


def test_headings_that_rules_compute() -> None:
    """Whom a rule turns, or sends with a computed heading, it turns with the map; so do phases with which an episode begins."""
    game = build(read_source(CASES / "headings.sj")).game
    tried = trials([(name, game) for name in range(3)], any_turn, steps=8, compiled=False)
    assert not tried.fault
    assert tried.steps >= 10


@pytest.mark.parametrize("name", ["pushing", "own_destinations", "cells"])
def test_sends(name: str) -> None:
    """Pushes turn with the map, also where two directions are equally far; so do destinations that depend on who is sent."""
    game = build(read_source(SENDS / f"{name}.sj")).game
    tried = trials([(name, game)] * 4, any_turn, steps=10, compiled=False)
    assert not tried.fault
    assert tried.steps >= 20

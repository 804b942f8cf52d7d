"""A map that wraps has no middle: with everything on it moved down and to the right, the play moves with it."""

from pathlib import Path

import pytest

from sjdsl.compiler import build, ir
from sjdsl.compiler.syntax.read import read_source
from tests.laws.corpus import FEW, random_games
from tests.laws.obeyed import trials
from tests.laws.symmetry import moved_on, turns

CASE = Path(__file__).parents[1] / "cases" / "wrapping.sj"


def joined(game: ir.Game) -> ir.Game:
    """Returns the rules on the same map with its edges joined."""
    return game.model_copy(update={"edges": "joined"})


def test_random_programs() -> None:
    """Every rule on a map that wraps is the same everywhere, whatever it was written for."""
    games = [(seed, joined(game)) for seed, game in random_games(FEW)]
    tried = trials(games, moved_on, steps=6, compiled=True)
    assert not tried.fault
    assert tried.steps > 4 * FEW
    assert tried.drawn > 40 * FEW


def test_a_map_with_edges_is_not_the_same_everywhere() -> None:
    """The law tells: what is looked at as if it wrapped, and does not, is found out."""
    tried = trials(
        random_games(FEW),
        lambda game, random: moved_on(joined(game), random),
        steps=6,
        compiled=False,
    )
    assert tried.fault


@pytest.mark.parametrize(
    "look",
    [moved_on, lambda game, random: random.choice(list(turns(game)))],
    ids=["moved", "turned"],
)
def test_all_that_looks_round_the_edges(look) -> None:
    """Lanes, discs, distances, pushes and movers of a small map, also where two ways round it are equally long."""
    game = build(read_source(CASE)).game
    tried = trials([(f"wrapping {n}", game) for n in range(4)], look, steps=10, compiled=True)
    assert not tried.fault
    assert tried.steps >= 20

"""A chance of 0 equals the rules without its branch, one of 1 the rules without the chance, number by number: written, and as a parameter."""

from dataclasses import replace
from random import Random

import pytest

from sjdsl.compiler import ir
from sjdsl.interpreter.state import default_params
from tests.games.environments import NINE
from tests.laws.chances import Site, sites, with_constant, with_param, without_branch, without_chance
from tests.laws.corpus import FEW, game_of, random_games
from tests.laws.trajectory import parting, start_of, trajectory

STEPS = 5


def parts(game: ir.Game, site: Site, probability: int, random: Random) -> str:
    """Returns where a chance of 0 or 1 differs from the rules without the branch, or without the chance; nothing where it does not."""
    start = start_of(game, random, STEPS)
    plain = (without_chance if probability else without_branch)(game, site)
    wanted = trajectory(plain, start)
    for name, made in (("a number", with_constant(game, site, probability)), ("a parameter", with_param(game, site, probability))):
        found = parting(wanted, trajectory(made, start, replace(start.world, params=default_params(made))))
        if found:
            return f"{probability} as {name} at {site}: {found}"
    return ""


def first_parting(game: ir.Game, probability: int, random: Random, most: int = 100) -> tuple[str, int]:
    """Returns the first difference at any branch of the game, and how many were tried."""
    tried = list(sites(game))
    for site in random.sample(tried, min(most, len(tried))):
        found = parts(game, site, probability, random)
        if found:
            return found, len(tried)
    return "", min(most, len(tried))


@pytest.mark.parametrize("probability", [0, 1])
@pytest.mark.parametrize("name", NINE)
def test_nine_games(name: str, probability: int) -> None:
    found, tried = first_parting(game_of(name), probability, Random(name))
    assert not found
    assert tried


@pytest.mark.parametrize("probability", [0, 1])
def test_random_programs(probability: int) -> None:
    branches = 0
    for seed, game in random_games(FEW):
        found, tried = first_parting(game, probability, Random(seed), most=1)
        assert not found, (seed, found)
        branches += tried
    assert branches >= FEW // 2

"""Chances of 0 and of 1 beside the rules without them: the same trajectories, number by number."""

from dataclasses import replace
from random import Random

from sjdsl.compiler import ir
from sjdsl.interpreter.state import default_params
from tests.laws.chances import (
    Site,
    sites,
    with_constant,
    with_param,
    without_branch,
    without_chance,
)
from tests.laws.trajectory import parting, start_of, trajectory

STEPS = 5


def parts(game: ir.Game, site: Site, probability: int, random: Random) -> str:
    """Returns where a chance of 0 or 1 differs from the rules without the branch, or without the chance; nothing where it does not."""
    start = start_of(game, random, STEPS)
    plain = (without_chance if probability else without_branch)(game, site)
    wanted = trajectory(plain, start)
    for name, made in (
        ("a number", with_constant(game, site, probability)),
        ("a parameter", with_param(game, site, probability)),
    ):
        found = parting(
            wanted, trajectory(made, start, replace(start.world, params=default_params(made)))
        )
        if found:
            return f"{probability} as {name} at {site}: {found}"
    return ""


def first_parting(
    game: ir.Game, probability: int, random: Random, most: int = 100
) -> tuple[str, int]:
    """Returns the first difference at any branch of the game, and how many were tried."""
    tried = list(sites(game))
    for site in random.sample(tried, min(most, len(tried))):
        found = parts(game, site, probability, random)
        if found:
            return found, len(tried)
    return "", min(most, len(tried))

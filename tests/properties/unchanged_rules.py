"""A step beside the same step of agents with other numbers, under the very same rules: what a symmetry says."""

from dataclasses import replace
from random import Random

from sjdsl.compiler import ir
from sjdsl.interpreter.overflow import LeavesFloat32
from sjdsl.interpreter.state import World
from sjdsl.interpreter.step import step
from sjdsl.interpreter.threefry import Recorded
from tests.fuzz.numpy_jax import as_array
from tests.fuzz.together import on_numpy, runs_away
from tests.laws.corpus import biased_draws, crowded, some_actions
from tests.laws.obeyed import compiled_difference
from tests.laws.other_draws import NeverDrawn, RunsOut, other_draws, tied
from tests.laws.other_world import (
    other_outcome,
    other_world,
    outcome_differences,
    world_differences,
)
from tests.laws.symmetry import renamed
from tests.properties.random_worlds import as_interpreted, encoded, random_params

STEPS, TRIES = 5, 3


def asymmetry(game: ir.Game, check: ir.Check, random: Random) -> tuple[int, str]:
    """Returns how many steps were compared, and where one differed; no steps where this cannot be told."""
    if check.words[0] != "agents":
        return 0, ""
    compared = 0
    for _ in range(TRIES):
        s, env = renamed(game, random), on_numpy(game)
        params = random_params(game, random)
        env.params = replace(
            env.params, **{name: as_array(value) for name, value in encoded(game, params).items()}
        )
        world = replace(crowded(game, random), params=as_interpreted(game, params))
        for _ in range(STEPS):
            actions, drawn, before = (
                some_actions(game, random, world),
                Recorded(biased_draws(random)),
                world,
            )
            try:
                world, outcome = step(game, before, actions, before.params, drawn)
                words = other_draws(game, game, drawn, s)
            except RunsOut:
                continue
            except (
                LeavesFloat32,
                AssertionError,
            ):  # the interpreter asserts that whole numbers keep to int32
                break
            if runs_away(world):
                break
            if tied(game, drawn):
                continue
            given = [s.number(actions[s.order.index(agent)], game) for agent in range(len(actions))]
            start, wanted = (
                other_world(game, game, before, s),
                (other_world(game, game, world, s), other_outcome(game, outcome, s)),
            )
            where = _differs(game, start, given, words, wanted) or compiled_difference(
                env, start, given, words, wanted
            )
            if where:
                return compared, f"{s}: {where}"
            compared += 1
    return compared, ""


def _differs(
    game: ir.Game, start: World, actions: list[int], words: object, wanted: tuple[World, object]
) -> str:
    try:
        after, outcome = step(game, start, actions, start.params, words)  # type: ignore[arg-type]
    except NeverDrawn as draw:
        return f"a draw that the first game did not make: {draw}"
    found = world_differences(after, wanted[0]) + outcome_differences(outcome, wanted[1])  # type: ignore[arg-type]
    return found[0] if found else ""

"""One trajectory of a game beside the trajectory of the game under a symmetry, step by step, on the interpreter and as compiled."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import lru_cache
from random import Random
from typing import Any

import numpy as np

from sjdsl.compiler import ir
from sjdsl.interpreter.observe import observe
from sjdsl.interpreter.state import World
from sjdsl.interpreter.step import action_mask, reset, step
from sjdsl.interpreter.threefry import Recorded
from sjdsl.testing.differences import outcome_differences as differs_from_outcome
from sjdsl.testing.differences import state_differences
from tests.fuzz import numpy_jax
from tests.fuzz.together import OnNumPy, on_numpy, runs_away
from tests.laws.corpus import begun, biased_draws, crowded, some_actions
from tests.laws.numpy_state import numpy_state
from tests.laws.other_draws import NeverDrawn, RunsOut, Table, other_draws, tied
from tests.laws.other_game import other_game, without_frame
from tests.laws.other_world import (
    other_outcome,
    other_view,
    other_world,
    outcome_differences,
    world_differences,
)
from tests.laws.symmetry import Symmetry


@dataclass
class Tried:
    """`steps` in which the law held; `drawn`: words they used; `left_out`: steps about which it says nothing."""

    steps: int = 0
    drawn: int = 0
    left_out: int = 0
    fault: str = ""


def obeyed(game: ir.Game, s: Symmetry, random: Random, steps: int, compiled: bool) -> Tried:
    """Plays a trajectory and, after each step, the same step under the symmetry. `compiled`: as compiled, too."""
    game = without_frame(game)
    changed = other_game(game, s)
    env = _environment(changed) if compiled else None
    tried = Tried()
    tried.fault = _reset(game, changed, s, random)
    world = (crowded if random.random() < 0.8 else begun)(game, random)
    for number in range(steps):
        if tried.fault:
            return tried
        actions, drawn = some_actions(game, random, world), Recorded(biased_draws(random))
        before = world
        world, outcome = step(game, before, actions, before.params, drawn)
        if runs_away(world):  # sums in another order differ by more and more
            tried.left_out += 1
            return tried
        try:
            words = other_draws(game, changed, drawn, s)
        except RunsOut:
            tried.left_out += 1
            continue
        wanted = other_world(game, changed, world, s), other_outcome(game, outcome, s)
        given = [s.number(actions[s.order.index(agent)], game) for agent in range(len(actions))]
        start = other_world(game, changed, before, s)
        fault = _interpreted(game, changed, start, given, words, wanted, world, s)
        if env is not None and not fault:
            fault = compiled_difference(env, start, given, words, wanted)
        if fault and tied(game, drawn):  # of equal ranks numbers decide
            tried.left_out += 1
            continue
        tried.fault = f"step {number}: {fault}" if fault else ""
        tried.steps += 1
        tried.drawn += len(drawn.used)
    return tried


def _reset(game: ir.Game, changed: ir.Game, s: Symmetry, random: Random) -> str:
    drawn = Recorded(biased_draws(random))
    world = begun(game, random)
    world = reset(game, world.params, drawn)
    try:
        words = other_draws(game, changed, drawn, s)
    except RunsOut:
        return ""
    try:
        found = world_differences(
            reset(changed, world.params, words), other_world(game, changed, world, s)
        )
    except NeverDrawn as draw:
        return f"reset: a draw that the first game did not make: {draw}"
    return f"reset: {found[0]}" if found else ""


def _interpreted(
    game: ir.Game,
    changed: ir.Game,
    start: World,
    actions: list[int],
    words: Table,
    wanted: Any,
    world: World,
    s: Symmetry,
) -> str:
    try:
        after, outcome = step(changed, start, actions, start.params, words)
    except NeverDrawn as draw:
        return f"a draw that the first game did not make: {draw}"
    found = world_differences(after, wanted[0]) + outcome_differences(outcome, wanted[1])
    mask, other_mask = np.array(action_mask(game, world)), np.array(action_mask(changed, after))
    numbers = [s.number(action, game) for action in range(mask.shape[1])]
    if not np.array_equal(other_mask[list(s.order)][:, numbers], mask):
        found.append("the actions allowed next")
    if not np.array_equal(observe(changed, after), other_view(game, observe(game, world), s)):
        found.append("what is seen")
    return found[0] if found else ""


def compiled_difference(
    env: OnNumPy, start: World, actions: list[int], words: Table, wanted: tuple[World, Any]
) -> str:
    """Returns where the compiled step from a state differs from the state and outcome wanted."""
    state = numpy_state(env, start)
    env.module.random_bits = lambda _, stream, *shape: _of(
        words, stream, np.arange(int(np.prod(shape, dtype=int))).reshape(shape)
    )
    env.module.random_bits_at = lambda _, stream, numbers: _of(words, stream, np.asarray(numbers))
    with np.errstate(all="ignore"):  # what a guard protects is computed and not used
        state, reward, _, info = env.advance((0, 0), state, actions)
        mask = np.asarray(env.module.allowed_actions(state, env.params))
        seen = env._observe(state)
    found = state_differences(env, state, wanted[0], seen, mask) + differs_from_outcome(
        env, reward, info, wanted[1]
    )
    return f"compiled: {found[0]}" if found else ""


def _of(words: Table, stream: int, numbers: np.ndarray) -> Any:
    """Returns words; those that no instance uses are computed as well, and may be anything."""
    found = [
        words.words.get((stream, int(n)), (int(n) + 1) * 0x9E3779B9 & 0xFFFFFFFF)
        for n in numbers.reshape(-1)
    ]
    return numpy_jax.as_array(np.array(found, np.uint32).reshape(numbers.shape))


@lru_cache(maxsize=16)
def _environment(game: ir.Game) -> OnNumPy:
    return on_numpy(game)


def trials(
    games: Iterable[tuple[Any, ir.Game]],
    look: Callable[[ir.Game, Random], Symmetry],
    steps: int,
    compiled: bool,
) -> Tried:
    """Returns what all games came to, up to the first that does not obey; a fault begins with the name or seed of its game."""
    tried = Tried()
    for name, game in games:
        random = Random(str(name))
        s = look(game, random)
        one = obeyed(game, s, random, steps, compiled)
        tried.steps, tried.drawn, tried.left_out = (
            tried.steps + one.steps,
            tried.drawn + one.drawn,
            tried.left_out + one.left_out,
        )
        if one.fault:
            tried.fault = f"{name}, {s}: {one.fault}"
            break
    return tried

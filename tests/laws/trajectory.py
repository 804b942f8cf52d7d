"""A trajectory of a compiled game on NumPy, from a crowded state and with draws that make rare events frequent, to be compared with that of changed rules."""

from dataclasses import dataclass
from random import Random
from typing import Any

import jax
import numpy as np

from sjdsl.compiler import ir
from sjdsl.interpreter.state import World
from tests.fuzz import numpy_jax
from tests.fuzz.together import OnNumPy, on_numpy, plain
from tests.laws.corpus import crowded, some_actions
from tests.laws.numpy_state import numpy_state


@dataclass(frozen=True)
class Start:
    """Where a trajectory begins, and what is done and drawn in it. `lively`: what is rare comes often."""

    world: World
    keys: list[tuple[int, int]]
    actions: list[list[int]]
    lively: bool


def start_of(game: ir.Game, random: Random, steps: int) -> Start:
    """Returns a random beginning."""
    keys = [(random.getrandbits(32), random.getrandbits(32)) for _ in range(steps)]
    return Start(
        crowded(game, random),
        keys,
        [some_actions(game, random) for _ in keys],
        random.random() < 0.7,
    )


def trajectory(game: ir.Game, start: Start, world: World | None = None) -> list[Any]:
    """Returns what is seen, kept, given and allowed, step by step. `world`: the same beginning as this game has it."""
    env = on_numpy(game)
    if start.lively:
        _enliven(env)
    seen = []
    with np.errstate(all="ignore"):  # what a guard protects is computed and not used
        state = numpy_state(env, world or start.world)
        for words, actions in zip(start.keys, start.actions, strict=True):
            state, reward, done, info = env.advance(words, state, actions)
            planes = [p.name for p in env.token_planes]
            view = dict(
                zip(planes, np.moveaxis(np.asarray(env._observe(state)), 1, 0), strict=True)
            )
            allowed = env.module.allowed_actions(state, env.params)
            seen.append(
                {
                    "state": plain(env, state),
                    "seen": view,
                    "given": (reward, done),
                    "info": info,
                    "allowed": allowed,
                }
            )
            if done:
                state = env.begin(words)
    return seen


def parting(mine: list[Any], theirs: list[Any]) -> str:
    """Returns where one trajectory leaves another, in what both have; the second may have more fields and planes."""
    for number, (a, b) in enumerate(zip(mine, theirs, strict=True)):
        for name, wanted in a.items():
            other = b[name]
            if isinstance(wanted, dict):  # what is kept of a state depends on what rules read
                wanted, other = (
                    {k: v for k, v in x.items() if k in wanted and k in other}
                    for x in (wanted, other)
                )
            for x, y in zip(jax.tree.leaves(wanted), jax.tree.leaves(other), strict=True):
                if not np.array_equal(
                    np.asarray(x), np.asarray(y), equal_nan=np.asarray(x).dtype.kind == "f"
                ):
                    return f"step {number}, {name}: {np.asarray(x).tolist()} / {np.asarray(y).tolist()}"
    return ""


def _enliven(env: OnNumPy) -> None:
    """Makes half of the words of a module small, by as much as they say themselves."""
    drawn = {
        name: getattr(env.module, name)
        for name in ("random_bits", "random_bits_at")
        if hasattr(env.module, name)
    }
    for name, function in drawn.items():

        def lively(*given: Any, function: Any = function) -> Any:
            word = np.asarray(function(*given))
            return numpy_jax.as_array(
                np.where(word & np.uint32(32) != 0, word >> (word & np.uint32(31)), word)
            )

        setattr(env.module, name, lively)

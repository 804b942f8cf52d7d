"""What a seed and a copy give in each adapter: the same course. Copies are made in the middle of an episode, by `copy` and by `pickle`."""

import copy
import pickle
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from sjdsl.interop import socialjax
from sjdsl.interop.dm_env import Substrate
from sjdsl.interop.gymnasium import AgentGame, VectorGame
from sjdsl.interop.jaxmarl import JaxMARLGame
from sjdsl.interop.pettingzoo import parallel_env
from sjdsl.interop.stable_baselines3 import VecGame

SHORT = {"params": {"length": 7, "spawn": 0.3}}
COPIES: dict[str, Callable[[Any], Any]] = {
    "deepcopy": copy.deepcopy,
    "pickle": lambda env: pickle.loads(pickle.dumps(env)),
}


def _paired(env: Any) -> Any:
    """Plays a step of PettingZoo's environment; after the last a reset."""
    return env.step({"agent_0": 0, "agent_1": 4}) if env.agents else env.reset()


def _alone(env: Any) -> Any:
    made = env.step(4)
    return (*made, env.reset()) if made[2] or made[3] else made


# how to make each, to begin an episode with a seed or without one, and to play a step
STANDING: dict[
    str, tuple[Callable[[int], Any], Callable[[Any, int | None], Any], Callable[[Any], Any]]
] = {
    "gymnasium": (
        lambda _: VectorGame("coins", 2, **SHORT),
        lambda env, seed: env.reset(seed=seed),
        lambda env: env.step(np.array([0, 4, 2, 3]))[:4],
    ),
    "gymnasium, one agent": (
        lambda _: AgentGame("coins", **SHORT),
        lambda env, seed: env.reset(seed=seed),
        _alone,
    ),
    "stable_baselines3": (
        lambda _: VecGame("coins", 2, **SHORT),
        lambda env, seed: (None if seed is None else env.seed(seed), env.reset()),
        lambda env: env.step(np.array([0, 4, 2, 3])),
    ),
    "pettingzoo": (
        lambda _: parallel_env("coins", **SHORT),
        lambda env, seed: env.reset(seed=seed),
        _paired,
    ),
    "dm_env": (
        lambda seed: Substrate("coins", seed=seed, **SHORT),
        lambda env, _: env.reset(),
        lambda env: env.step([0, 4]),
    ),
}


def alike(first: Any, second: Any) -> bool:
    return all(
        np.array_equal(x, y)
        for x, y in zip(jax.tree.leaves(first), jax.tree.leaves(second), strict=True)
    )


@pytest.mark.parametrize("adapter", STANDING)
def test_a_seed_is_a_course(adapter: str) -> None:
    """Over several episodes; another seed is another course, and so is a reset without one."""
    make, begin, step = STANDING[adapter]
    first, again, other = make(5), make(5), make(6)
    course = [begin(first, 5), *(step(first) for _ in range(30))]
    assert alike(course, [begin(again, 5), *(step(again) for _ in range(30))])
    assert not alike(course, [begin(other, 6), *(step(other) for _ in range(30))])
    assert not alike(course, [begin(first, None), *(step(first) for _ in range(30))])
    if adapter != "dm_env":  # which takes its seed when it is made
        assert alike(course, [begin(first, 5), *(step(first) for _ in range(30))])


@pytest.mark.parametrize("way", COPIES)
@pytest.mark.parametrize("adapter", STANDING)
def test_a_copy_plays_on_alike(adapter: str, way: str) -> None:
    make, begin, step = STANDING[adapter]
    env = make(3)
    begin(env, 3)
    for _ in range(3):
        step(env)
    copied, later = COPIES[way](env), COPIES[way](env)
    played = [step(env) for _ in range(9)]  # through an episode's end
    assert alike([step(copied) for _ in range(9)], played)
    assert alike(
        [step(later) for _ in range(9)], played
    )  # what the first two have played is nothing to it


@pytest.mark.parametrize("way", COPIES)
def test_copies_without_a_place(way: str) -> None:
    """Their states are copied beside them."""
    key = jax.random.key(4)
    actions = {"agent_0": jnp.int32(0), "agent_1": jnp.int32(4)}
    theirs = JaxMARLGame("coins", **SHORT)
    _, state = theirs.reset(key)
    copied, there = COPIES[way]((theirs, state))
    assert alike(copied.step(key, there, actions), theirs.step(key, state, actions))
    suite = socialjax.make("coin_game", shared_rewards=False)
    _, state = suite.reset(key)
    copied, there = COPIES[way]((suite, state))
    assert alike(copied.step(key, there, [0, 4]), suite.step(key, state, [0, 4]))

"""Copies of adapters in the middle of an episode, by `copy` and by `pickle`: they play on alike, and apart from the first."""

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
from sjdsl.interop.mava import MavaGame
from sjdsl.interop.pettingzoo import parallel_env
from sjdsl.interop.stable_baselines3 import VecGame

SHORT = {"params": {"length": 7, "spawn": 0.3}}
COPIES: dict[str, Callable[[Any], Any]] = {"deepcopy": copy.deepcopy, "pickle": lambda env: pickle.loads(pickle.dumps(env))}


def _paired(env: Any) -> Any:
    """Plays a step of PettingZoo's environment; after the last a reset."""
    return env.step({"agent_0": 0, "agent_1": 4}) if env.agents else env.reset()


def _alone(env: Any) -> Any:
    made = env.step(4)
    return (*made, env.reset()) if made[2] or made[3] else made


STANDING: dict[str, tuple[Callable[[], Any], Callable[[Any], Any], Callable[[Any], Any]]] = {
    "gymnasium": (lambda: VectorGame("coins", 2, **SHORT), lambda env: env.reset(seed=3), lambda env: env.step(np.array([0, 4, 2, 3]))[:4]),
    "gymnasium, one agent": (lambda: AgentGame("coins", **SHORT), lambda env: env.reset(seed=3), _alone),
    "stable_baselines3": (lambda: VecGame("coins", 2, **SHORT), lambda env: env.reset(), lambda env: env.step(np.array([0, 4, 2, 3]))),
    "pettingzoo": (lambda: parallel_env("coins", **SHORT), lambda env: env.reset(seed=3), _paired),
    "dm_env": (lambda: Substrate("coins", seed=3, **SHORT), lambda env: env.reset(), lambda env: env.step([0, 4])),
}


def assert_alike(first: Any, second: Any) -> None:
    a, b = jax.tree.leaves(first), jax.tree.leaves(second)
    assert len(a) == len(b) > 0
    assert all(np.array_equal(x, y) for x, y in zip(a, b, strict=True))


@pytest.mark.parametrize("way", COPIES)
@pytest.mark.parametrize("adapter", STANDING)
def test_a_copy_plays_on_alike(adapter: str, way: str) -> None:
    make, begin, step = STANDING[adapter]
    env = make()
    begin(env)
    for _ in range(3):
        step(env)
    copied, later = COPIES[way](env), COPIES[way](env)
    played = [step(env) for _ in range(9)]  # through an episode's end
    assert_alike([step(copied) for _ in range(9)], played)
    assert_alike([step(later) for _ in range(9)], played)  # what the first two have played is nothing to it


@pytest.mark.parametrize("way", COPIES)
def test_copies_without_a_place(way: str) -> None:
    """Their states are copied beside them."""
    key = jax.random.key(4)
    actions = {"agent_0": jnp.int32(0), "agent_1": jnp.int32(4)}
    theirs = JaxMARLGame("coins", **SHORT)
    _, state = theirs.reset(key)
    copied, there = COPIES[way]((theirs, state))
    assert_alike(copied.step(key, there, actions), theirs.step(key, state, actions))
    mava = MavaGame("coins", **SHORT)
    state, _ = mava.reset(jax.random.PRNGKey(4))
    copied, there = COPIES[way]((mava, state))
    assert_alike(copied.step(there, jnp.array([0, 4])), mava.step(state, jnp.array([0, 4])))
    suite = socialjax.make("coin_game", shared_rewards=False)
    _, state = suite.reset(key)
    copied, there = COPIES[way]((suite, state))
    assert_alike(copied.step(key, there, [0, 4]), suite.step(key, state, [0, 4]))

"""Whole games in the forms of kernels for GPUs, forced on this machine: the same states, rewards and observations, bit for bit."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from sjdsl.runtime.env import Environment
from sjdsl.runtime.forms import forced
from tests.games.environments import NINE, environment

ENVS, STEPS = 4, 40
USUAL = "coins"  # each kernel alone is played in both forms in tests/runtime


def played(env: Environment, form: str) -> Any:
    """Returns all that some environments gave in some steps, the ends of episodes among them."""
    params = env.params.replace(length=jnp.int32(15))

    def step(state: Any, key: Any) -> Any:
        keys = jax.random.split(key, ENVS)
        actions = jax.random.randint(key, (ENVS, env.num_agents), 0, env.num_actions)
        observation, state, reward, done, _ = jax.vmap(env.step, in_axes=(0, 0, 0, None))(
            keys, state, actions, params
        )
        return state, (state, observation, reward, done)

    def play(key: Any) -> Any:
        first, *keys = jax.random.split(key, STEPS + 1)
        _, state = jax.vmap(env.reset, in_axes=(0, None))(jax.random.split(first, ENVS), params)
        return jax.lax.scan(step, state, jnp.stack(keys))[1]

    with forced(form):
        return jax.tree.map(np.asarray, jax.jit(play)(jax.random.PRNGKey(3)))


@pytest.mark.parametrize(
    "game",
    [pytest.param(name, marks=() if name == USUAL else pytest.mark.thorough) for name in NINE],
)
def test_both_forms_play_alike(game: str) -> None:
    env = environment(game)
    found, expected = played(env, "gpu"), played(env, "cpu")
    assert expected[-1].sum() == 2 * ENVS  # two episodes have ended in each
    for (path, mine), (_, other) in zip(
        *map(jax.tree_util.tree_leaves_with_path, (found, expected)), strict=True
    ):
        np.testing.assert_array_equal(mine, other, err_msg=jax.tree_util.keystr(path))

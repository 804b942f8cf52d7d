"""Compiled policies choose what interpreted ones do, agent by agent, in states that play leads to."""

from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import sjdsl
from sjdsl.policies.compiled import make_chooser
from sjdsl.policies.interpreted import choose
from sjdsl.runtime.policy import random_policy
from tests.differential.worlds import world_of

GAMES = Path(__file__).parent / "games"
STEPS = 12


def worlds(env: sjdsl.Environment, seed: int):
    """Yields states that random play and the policies themselves lead to."""
    key = jax.random.key(seed)
    key, reset_key = jax.random.split(key)
    observation, state = env.reset(reset_key)
    play = random_policy(env)
    for _ in range(STEPS):
        yield state
        key, act_key, step_key = jax.random.split(key, 3)
        observation, state, *_ = env.step(step_key, state, play(act_key, observation))


@pytest.mark.parametrize("path", sorted(GAMES.glob("*.sj")), ids=lambda path: path.stem)
def test_compiled_equals_interpreted(path: Path) -> None:
    env = sjdsl.make(path)
    drawn = np.random.default_rng(0)
    params = {param.name: param.value for param in env.game.params}
    for policy in env.game.policies:
        chooser = jax.jit(make_chooser(env, policy))
        chosen = set()
        for seed in range(2):
            for state in worlds(env, seed):
                bits = drawn.integers(0, 2**32, (env.num_agents, 2), np.uint32)
                world = world_of(env, state, params)
                expected = [choose(policy, env.game, world, agent, tuple(map(int, bits[agent]))) for agent in range(env.num_agents)]
                assert np.asarray(chooser(state, jnp.asarray(bits))).tolist() == expected, (policy.name, world)
                chosen |= set(expected)
        assert len(chosen) > 1, f"{policy.name} always does the same"

"""Plays episodes to be drawn: snapshots of one environment under a policy."""

from collections.abc import Iterator
from functools import partial

import jax
import numpy as np

from sjdsl.render.snapshot import Snapshot, take_snapshot
from sjdsl.runtime.env import Environment
from sjdsl.runtime.policy import Policy, random_policy, stay_policy, take_actions, with_memory

__all__ = ["play", "random_policy", "stay_policy"]


def play(env: Environment, policy: Policy, num_steps: int, seed: int = 0, every: int = 1) -> Iterator[Snapshot]:
    """Yields the first state of each episode and one of `every` states that follow, an episode's last one included.

    Args:
      policy: `(key, observation) -> actions [N]`, or one with memory.
      num_steps: steps to play, over as many episodes as they take.
    """
    key, reset_key = jax.random.split(jax.random.key(seed))
    observation, state = env.reset(reset_key)
    returns = np.zeros(env.num_agents)
    remembering = with_memory(policy)
    memory = remembering.start
    act = jax.jit(partial(take_actions, env, remembering))
    yield take_snapshot(env, state, returns)
    for number in range(1, num_steps + 1):
        key, action_key, step_key, reset_key = jax.random.split(key, 4)
        memory, actions = act(memory, action_key, observation, state)
        observation, state, reward, done, _ = env.step_env(step_key, state, actions)
        returns = returns + np.asarray(reward)
        if number % every == 0 or done:
            yield take_snapshot(env, state, returns)
        if done and number < num_steps:
            observation, state = env.reset(reset_key)
            memory = remembering.start
            returns = np.zeros(env.num_agents)
            yield take_snapshot(env, state, returns)

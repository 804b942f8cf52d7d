"""Exploration by random preferences among actions, which all agents of an environment share."""

import jax
import jax.numpy as jnp
from jax import Array

from ..devices.data_parallel import own_keys, own_numbers
from ..settings.config import PPOConfig

DURATION = 0.5  # of a run, after which no environment has preferences


def draw_preferences(
    key: Array, num_envs: int, num_actions: int, updates: Array, config: PPOConfig
) -> Array:
    """Returns what is added to the logits of all agents in each environment: `[B, A]` float32.

    It stays the same for a whole rollout, so that the agents of an environment do things together
    that agents who each draw their own actions hardly ever do, such as cleaning a river. The
    policy is trained with the preferences added.

    Their deviation grows evenly from the first environment to the last, and falls by the same
    amount in all of them: the first environments soon have none, so that policies learn to do
    without, while in the last ones agents explore for half of the run.

    The idea that noise should last for many steps is that of Plappert et al. 2018, "Parameter
    space noise for exploration", who add it to all parameters of the policy. Exploring more in
    some environments than in others is that of Horgan et al. 2018, "Distributed prioritized
    experience replay", whose actors have different epsilons.

    Args:
      key: consumed.
      num_envs: the environments on this device.
      updates: `[]` int32, updates done.
    """
    share_of_deviation = (own_numbers(num_envs) + 1) / config.num_envs
    done = updates / (DURATION * config.num_updates)
    deviation = config.preference_noise * jnp.maximum(share_of_deviation - done, 0.0)
    keys = own_keys(key, num_envs)
    drawn = jax.vmap(lambda env_key: jax.random.normal(env_key, (num_actions,)))(keys)
    return deviation[:, None] * drawn

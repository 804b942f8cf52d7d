"""Agents that act by action values: the network that they share, and how they explore."""

import jax
import jax.numpy as jnp
from jax import Array

from ..environment import Environment
from ..settings.config import VDNConfig
from .actor_critics import token_planes
from .architectures import ActionValues
from .masks import draw_any, masked


def make_action_values(env: Environment, config: VDNConfig) -> ActionValues:
    """Returns the network, which all agents share.

    Raises:
      ConfigError: the environment has no token observations.
    """
    return ActionValues(
        num_actions=env.num_actions,
        planes=token_planes(env),
        config=config,
        numbers=env.num_agents if config.agent_id else 0,
    )


def explore(key: Array, values: Array, allowed: Array | None, epsilon: Array | float) -> Array:
    """Returns the best allowed action of values `[..., A]`, or with `epsilon` a random one."""
    explore_key, action_key = jax.random.split(key)
    best = best_action(values, allowed)
    explores = jax.random.bernoulli(explore_key, epsilon, best.shape)
    drawn = draw_any(action_key, best.shape, values.shape[-1], allowed)
    return jnp.where(explores, drawn, best)


def best_action(values: Array, allowed: Array | None) -> Array:
    """Returns the allowed action `[...]` int32 with the highest value of `[..., A]`."""
    return jnp.argmax(masked(values, allowed), axis=-1).astype(jnp.int32)


def values_of_actions(values: Array, action: Array) -> Array:
    """Returns the values of the given actions `[...]` from those of all actions `[..., A]`."""
    return jnp.take_along_axis(values, action[..., None], axis=-1)[..., 0]


def exploration(config: VDNConfig, updates: Array) -> Array:
    """Returns the probability of exploring after some updates: linear, then constant."""
    gone = jnp.minimum(updates / (config.epsilon_fraction * config.num_updates), 1.0)
    change = config.epsilon_end - config.epsilon_start
    return (config.epsilon_start + gone * change).astype(jnp.float32)

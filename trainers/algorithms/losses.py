"""The input of the losses of policies and critics, and their parts."""

from collections.abc import Callable
from typing import Any

import flax
import jax
import jax.numpy as jnp
from jax import Array

from ..devices.data_parallel import mean_of_all
from ..networks.action_values import values_of_actions
from ..networks.architectures import Memory
from ..settings.config import PPOConfig
from .training_functions import Metrics

Apply = Callable[..., tuple[Memory, Array, Array]]  # a team's network: `ActorCritic.apply`

# (parameters, apply, batch, config) -> what is made smaller, and its parts
Loss = Callable[..., tuple[Array, Metrics]]


@flax.struct.dataclass
class Batch:
    """A rollout to learn from, as M sequences of L steps.

    L is 1 for networks without memory, T with it. A minibatch has some of the sequences, with the
    agents of one team.
    """

    observation: Array  # [L, M, N, bytes] uint8, packed; in a minibatch [L, m, S, P, V, V]
    # [L, M, ...] what critics read besides windows; in a minibatch as networks read it, [L, m, ...]
    joint: Any
    fresh: Array  # [L, M] bool
    # [M, G, ...] before the first of the L steps; `last`, what agents read of their last steps, has
    # all of them, [M, G, L, S]
    memory: Memory
    action: Array  # [L, M, N] int32
    log_probability: Array  # [L, M, N] float32, when drawn
    value: Array  # [L, M, N] float32, when drawn
    advantage: Array  # [L, M, N] float32
    target: Array  # [L, M, N] float32, of the value
    allowed: Array | None = None  # [L, M, N, A] bool, which actions; None: all
    # [L, M, A] float32, added to the logits of all agents; None: none
    preferences: Array | None = None


def chosen_log_probability(logits: Array, action: Array) -> Array:
    """Returns the log probability `[...]` of each action under logits `[..., A]`."""
    return values_of_actions(jax.nn.log_softmax(logits), action)


def normalised(advantage: Array, config: PPOConfig) -> Array:
    """Returns advantages minus their mean, divided by their deviation or by `advantage_floor`."""
    # Without any reward, advantages are only the critic's errors; divided by their own deviation,
    # they would move the policy as far as rewards do.
    centred: Array = advantage - mean_of_all(advantage.mean())
    deviation = jnp.sqrt(mean_of_all(jnp.square(centred).mean()))
    return centred / jnp.maximum(deviation, config.advantage_floor + 1e-8)


def clipped_surrogate(ratio: Array, advantage: Array, epsilon: float) -> Array:
    """Returns min(ratio * advantage, clip(ratio, 1 - epsilon, 1 + epsilon) * advantage).

    Source: Schulman et al. 2017, equation 7.
    """
    clipped_ratio = jnp.clip(ratio, 1.0 - epsilon, 1.0 + epsilon)
    return jnp.minimum(ratio * advantage, clipped_ratio * advantage)


def value_loss(
    value: Array, before: Array, target: Array, unit: Array | float, config: PPOConfig
) -> Array:
    """Returns half the mean squared error of values, in a unit.

    With `clip_value_loss`, values are clipped about those `before`, when acting (Huang et al.
    2022).
    """
    squared_error = jnp.square((value - target) / unit)
    if config.clip_value_loss:
        change = jnp.clip((value - before) / unit, -config.clip_epsilon, config.clip_epsilon)
        squared_error = jnp.maximum(squared_error, jnp.square((before - target) / unit + change))
    return 0.5 * squared_error.mean()


def mean_entropy(logits: Array) -> Array:
    """Returns the mean entropy of the policies with logits `[..., A]`, in nats."""
    return -(jax.nn.softmax(logits) * jax.nn.log_softmax(logits)).sum(axis=-1).mean()

"""Generalised advantage estimation (GAE): discounted credit for actions, with bootstrapping.

It is bootstrapped at truncations, but not at terminations.
"""

import jax
import jax.numpy as jnp
from jax import Array


def successor_values(
    values: Array, last_value: Array, terminal_values: Array, done: Array, truncated: Array
) -> Array:
    """Returns the bootstrap value after each step.

    Inside an episode it is the value of the next observation. After a truncation it is the value of
    the observation at which the episode was cut, because rewards would have continued. After a
    termination it is zero.

    Args:
      values: `[T, B, N]` value of the observation acted on.
      last_value: `[B, N]` value of the observation after the last step.
      terminal_values: `[T, B, N]` value of the terminal observation, read where `truncated`.
      done: `[T, B]` bool, the episode ended with this step, for either reason.
      truncated: `[T, B]` bool, it ended by the time limit.
    Returns:
      `[T, B, N]`.
    """
    following = jnp.concatenate([values[1:], last_value[None]])
    following = jnp.where(done[..., None], 0.0, following)
    return jnp.where(truncated[..., None], terminal_values, following)


def generalised_advantages(
    rewards: Array, values: Array, successors: Array, done: Array, gamma: float, gae_lambda: float
) -> Array:
    """Returns the advantage of each action.

    delta_t = r_t + gamma * V(s_{t+1}) - V(s_t);  A_t = delta_t + gamma * lambda * A_{t+1}, cut
    after each episode.

    Args:
      rewards: `[T, B, N]` shaped rewards.
      values: `[T, B, N]` value of the observation acted on.
      successors: `[T, B, N]` from `successor_values`.
      done: `[T, B]` bool.
      gamma: discount per step.
      gae_lambda: weight of longer returns.
    Returns:
      `[T, B, N]`; added to `values` it is the value target.
    Source: Schulman et al. 2016, equation 16.
    """
    deltas = rewards + gamma * successors - values
    decay = gamma * gae_lambda * (1.0 - done[..., None].astype(values.dtype))

    def backwards(advantage: Array, step: tuple[Array, Array]) -> tuple[Array, Array]:
        delta, keep = step
        advantage = delta + keep * advantage
        return advantage, advantage

    _, advantages = jax.lax.scan(
        backwards, jnp.zeros_like(deltas[0]), (deltas, decay), reverse=True
    )
    return advantages

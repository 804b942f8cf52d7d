"""Shaped rewards: pure functions of the game's raw rewards, `[..., N] -> [..., N]`."""

from typing import Literal, assert_never

import jax.numpy as jnp
from jax import Array

RewardMode = Literal["individual", "common"]


def shape_reward(reward: Array, mode: RewardMode) -> Array:
    """Returns the reward each agent learns from.

    individual: agent i learns from its own reward, u_i = r_i.
    common: every agent learns from the group's, u_i = sum over j of r_j.

    Args:
      reward: `[..., N]` raw rewards.
      mode: whose reward counts.
    Returns:
      `[..., N]` shaped rewards.
    """
    match mode:
        case "individual":
            return reward
        case "common":
            return jnp.broadcast_to(reward.sum(axis=-1, keepdims=True), reward.shape)
        case _:
            assert_never(mode)

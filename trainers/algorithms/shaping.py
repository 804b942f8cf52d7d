"""Reward shaping: pure functions of raw rewards such as SVO, inequity aversion and reward exchange, `[..., N] -> [..., N]`.

The environment pays raw rewards and knows nothing of these; metrics have both.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import get_args

import jax.numpy as jnp
from jax import Array

from ..settings.config import Config, ConfigError
from ..settings.extensions import RewardMode
from ..settings.own_settings import filled
from .step_record import Step


@dataclass(frozen=True)
class Shaping:
    """Which rewards agents learn from.

    `shape(reward, trace)` takes raw rewards and their traces, both `[..., N]`. A trace adds up an episode's rewards with
    decay, e_t = smoothing * e_{t-1} + r_t; with smoothing 0 it is the reward. A user's `own` reward sees a whole step of one environment
    instead.
    """

    shape: Callable[[Array, Array], Array]
    smoothing: float
    own: Callable[[Step], Array] | None = None


def make_shaping(config: Config, num_agents: int) -> Shaping:
    """Returns the shaping of a configuration.

    Raises:
      ConfigError: `svo_angle` has neither one angle nor one for each agent.
    """
    scale = float(num_agents) if config.match_socialjax else 1.0

    def shape(reward: Array, trace: Array) -> Array:
        match config.reward:
            case "individual":
                return scale * reward
            case "common":
                shared = (
                    common_mean(reward) if config.common_reward == "mean" else common_sum(reward)
                )
                return shared * (
                    scale if config.algorithm == "vdn" else 1.0
                )  # there VDN adds up sums
            case "exchange":
                return scale * exchanged(reward, kept_share(config.exchange_ratio, num_agents))
            case "inequity":
                return scale * inequity_averse(
                    reward, trace, config.inequity_envy, config.inequity_guilt
                )
            case "svo":
                # Counted from what an agent loses while nobody is rewarded: a constant loss in each step, pi / 2 at 90 degrees, teaches
                # nothing in episodes of a fixed length, but the critic would learn little else, and the policy with it.
                at_rest = svo_deviation(
                    jnp.zeros_like(trace), angles, config.svo_at_rest, config.svo_quadrant
                )
                penalty = (
                    svo_deviation(trace, angles, config.svo_at_rest, config.svo_quadrant) - at_rest
                )
                return scale * (reward - config.svo_weight * penalty)
            case _:
                raise AssertionError(config.reward)  # a user's own reward isn't shaped

    degrees = config.svo_angle * num_agents if len(config.svo_angle) == 1 else config.svo_angle
    if len(degrees) != num_agents:
        raise ConfigError(
            f"`svo_angle` must be one angle, or one for each of the {num_agents} agents, not {len(degrees)}"
        )
    angles = jnp.asarray(
        [angle * (math.pi / 180) for angle in degrees], jnp.float32
    )  # not math.radians: angles may be traced
    smoothing = (
        config.gamma * config.inequity_smoothing
        if config.reward == "inequity"
        else config.reward_smoothing
    )
    own = (
        None
        if config.reward in get_args(RewardMode)
        else filled("reward", config.reward, config.own)
    )
    return Shaping(shape, smoothing, own)


def common_sum(reward: Array) -> Array:
    """u_i = sum over j of r_j."""
    return jnp.broadcast_to(reward.sum(axis=-1, keepdims=True), reward.shape)


def common_mean(reward: Array) -> Array:
    """u_i = (1 / n) * sum over j of r_j."""
    return jnp.broadcast_to(reward.mean(axis=-1, keepdims=True), reward.shape)


def kept_share(ratio: float, num_agents: int) -> float:
    """Returns s, how much of its reward an agent keeps, where another's reward counts `ratio` times as much as its own.

    s = 1 / (1 + ratio * (n - 1)): 1 at ratio 0, 1 / n at ratio 1.
    """
    return 1.0 / (1.0 + ratio * (num_agents - 1))


def exchanged(reward: Array, kept: float | Array) -> Array:
    """Reward exchange: u_i = s * r_i + (1 - s) / (n - 1) * sum over j != i of r_j.

    Args:
      reward: `[..., N]`.
      kept: s; an agent that is alone exchanges nothing.
    Source: Willis et al. 2023, "Resolving social dilemmas through reward transfer commitments".
    """
    number = reward.shape[-1]
    if number == 1:
        return reward
    others = reward.sum(axis=-1, keepdims=True) - reward
    return kept * reward + (1.0 - kept) / (number - 1) * others


def inequity_averse(reward: Array, trace: Array, envy: float, guilt: float) -> Array:
    """u_i = r_i - envy / (n - 1) * sum_j max(e_j - e_i, 0) - guilt / (n - 1) * sum_j max(e_i - e_j, 0).

    Args:
      reward: `[..., N]`, raw.
      trace: `[..., N]`, temporally smoothed rewards, e_t = gamma * lambda * e_{t-1} + r_t: agents that are paid at different steps are
        compared by what they got lately, as people would.
      envy: weight of disadvantageous inequity, alpha; guilt: of advantageous, beta.
    Source: Hughes et al. 2018, "Inequity aversion improves cooperation in intertemporal social dilemmas", equation 3 and the smoothed
    rewards that it is of; alpha 5 and beta 0.05 are theirs, the value of lambda is ours.
    """
    others = max(reward.shape[-1] - 1, 1)
    ahead = trace[..., None, :] - trace[..., :, None]  # [..., i, j] by how much j is ahead of i
    return (
        reward
        - (envy * jnp.maximum(ahead, 0.0).sum(-1) + guilt * jnp.maximum(-ahead, 0.0).sum(-1))
        / others
    )


def svo_deviation(trace: Array, sought: Array, at_rest: str, quadrant: bool) -> Array:
    """Returns how far each agent's social value orientation is from the one it seeks, in radians.

    The orientation is the angle between an agent's own reward and the mean of the others', theta_i = atan2(mean of the
    others, own). Where all are 0 there is no angle: `selfish` takes 0, as atan2 does; `content` takes the one sought, so that
    nothing is deducted while nobody is rewarded. A negative reward leads out of the quadrant 0 .. 90 degrees for which the
    theory defines the angle; `quadrant` clips it.

    Args:
      trace: `[..., N]`.
      sought: `[N]` radians.
    Returns:
      `[..., N]` |theta - sought|, the plain difference of angles from -pi to pi.
    Source: McKee et al. 2020, "Social diversity and social preferences in mixed-motive reinforcement learning", section 3.2.
    """
    others = max(trace.shape[-1] - 1, 1)
    mean_of_others = (trace.sum(axis=-1, keepdims=True) - trace) / others
    resting = (trace == 0.0) & (mean_of_others == 0.0)
    angle = jnp.arctan2(jnp.where(resting, 0.0, mean_of_others), jnp.where(resting, 1.0, trace))
    if quadrant:
        angle = jnp.clip(angle, 0.0, math.pi / 2)
    away = jnp.abs(angle - sought)
    return jnp.where(resting, 0.0, away) if at_rest == "content" else away

"""Reward shaping: pure functions of raw rewards, `[..., N] -> [..., N]`.

They are SVO, inequity aversion, reward exchange and common rewards. The environment pays raw
rewards and knows nothing of these; metrics have both.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import jax
import jax.numpy as jnp
from jax import Array

from ..settings.config import Config, ConfigError
from ..settings.own_settings import filled
from .step_record import Step


@dataclass(frozen=True)
class Shaping:
    """Which rewards `[B, N]` agents learn from, after a step of B environments.

    They come from raw rewards and their traces. A trace adds up an episode's rewards with decay,
    e_t = smoothing * e_{t-1} + r_t; with smoothing 0 it is the reward. A user's own reward sees the
    whole step of each environment.
    """

    shape: Callable[[Step], Array]
    smoothing: float


def make_shaping(config: Config, num_agents: int) -> Shaping:
    """Returns the shaping of a configuration.

    Raises:
      ConfigError: `svo_angle` has neither one angle nor one for each agent; when it is traced, a
        user's own reward gives something else than a number for each agent.
    """
    scale = float(num_agents) if config.match_socialjax else 1.0
    degrees = config.svo_angle * num_agents if len(config.svo_angle) == 1 else config.svo_angle
    if len(degrees) != num_agents:
        raise ConfigError(
            f"`svo_angle` must be one angle, or one for each of the {num_agents} agents, "
            f"not {len(degrees)}"
        )
    # not math.radians: angles may be traced
    angles = jnp.asarray([angle * (math.pi / 180) for angle in degrees], jnp.float32)

    def shape(step: Step) -> Array:
        """Returns the shaped rewards `[B, N]` of a step."""
        reward = step.reward
        trace = step.trace
        match config.reward:
            case "individual":
                return scale * reward
            case "common":
                shared = common_mean if config.common_reward == "mean" else common_sum
                # There VDN adds up sums.
                return shared(reward) * (scale if config.algorithm == "vdn" else 1.0)
            case "exchange":
                return scale * exchanged(reward, kept_share(config.exchange_ratio, num_agents))
            case "inequity":
                averse = inequity_averse(reward, trace, config.inequity_envy, config.inequity_guilt)
                return scale * averse
            case "svo":
                return scale * (reward - config.svo_weight * svo_penalty(trace))
            case own:
                own_reward = filled("reward", own, config.own)
                paid: Array = jax.vmap(lambda step: jnp.asarray(own_reward(step)))(step)
                if paid.shape != reward.shape:
                    raise ConfigError(
                        f"the reward `{own}` must give a number for each of the {num_agents} "
                        f"agents, an array of shape ({num_agents},), not {paid.shape[1:]}"
                    )
                return paid.astype(jnp.float32)

    def svo_penalty(trace: Array) -> Array:
        """Returns the deviation, counted from that while nobody is rewarded.

        A constant loss in each step, pi / 2 at 90 degrees, teaches nothing in episodes of a fixed
        length, but the critic would learn little else, and the policy with it.
        """
        deviation = partial(
            svo_deviation, sought=angles, at_rest=config.svo_at_rest, quadrant=config.svo_quadrant
        )
        return deviation(trace) - deviation(jnp.zeros_like(trace))

    if config.reward == "inequity":
        return Shaping(shape, config.gamma * config.inequity_smoothing)
    return Shaping(shape, config.reward_smoothing)


def common_sum(reward: Array) -> Array:
    """Returns the sum of all rewards for each agent: u_i = sum over j of r_j."""
    return jnp.broadcast_to(reward.sum(axis=-1, keepdims=True), reward.shape)


def common_mean(reward: Array) -> Array:
    """Returns the mean of all rewards for each agent: u_i = (1 / n) * sum over j of r_j."""
    return jnp.broadcast_to(reward.mean(axis=-1, keepdims=True), reward.shape)


def kept_share(ratio: float, num_agents: int) -> float:
    """Returns s, how much of its reward an agent keeps.

    Another's reward counts `ratio` times as much as its own: s = 1 / (1 + ratio * (n - 1)): 1 at
    ratio 0, 1 / n at ratio 1.
    """
    return 1.0 / (1.0 + ratio * (num_agents - 1))


def exchanged(reward: Array, kept: float | Array) -> Array:
    """Returns rewards of which agents keep a share, and give the rest to the others.

    u_i = s * r_i + (1 - s) / (n - 1) * sum over j != i of r_j.

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
    """Returns rewards less what agents lose by inequity.

    u_i = r_i - (envy * sum_j max(e_j - e_i, 0) + guilt * sum_j max(e_i - e_j, 0)) / (n - 1).

    Args:
      reward: `[..., N]`, raw.
      trace: `[..., N]`, temporally smoothed rewards, e_t = gamma * lambda * e_{t-1} + r_t: agents
        that are paid at different steps are compared by what they got lately, as people would.
      envy: weight of disadvantageous inequity, alpha; guilt: of advantageous, beta.
    Source: Hughes et al. 2018, "Inequity aversion improves cooperation in intertemporal social
    dilemmas", equation 3 and the smoothed rewards that it is of; alpha 5 and beta 0.05 are theirs,
    the value of lambda is ours.
    """
    others = max(reward.shape[-1] - 1, 1)
    ahead = trace[..., None, :] - trace[..., :, None]  # [..., i, j] by how much j is ahead of i
    disadvantage = jnp.maximum(ahead, 0.0).sum(-1)
    advantage = jnp.maximum(-ahead, 0.0).sum(-1)
    return reward - (envy * disadvantage + guilt * advantage) / others


def svo_deviation(trace: Array, sought: Array, at_rest: str, quadrant: bool) -> Array:
    """Returns how far each agent's social value orientation is from the one it seeks, in radians.

    The orientation is the angle between an agent's own reward and the mean of the others', theta_i
    = atan2(mean of the others, own). Where all are 0 there is no angle: `selfish` takes 0, as atan2
    does; `content` takes the one sought, so that nothing is deducted while nobody is rewarded. A
    negative reward leads out of the quadrant 0 .. 90 degrees for which the theory defines the
    angle; `quadrant` clips it.

    Args:
      trace: `[..., N]`, decayed sums of rewards (`Shaping`), in place of the rewards themselves.
      sought: `[N]` radians.
    Returns:
      `[..., N]` |theta - sought|, the plain difference of angles from -pi to pi.
    Source: McKee et al. 2020, "Social diversity and social preferences in mixed-motive
    reinforcement learning", section 3.2.
    """
    others = max(trace.shape[-1] - 1, 1)
    mean_of_others = (trace.sum(axis=-1, keepdims=True) - trace) / others
    resting = (trace == 0.0) & (mean_of_others == 0.0)
    angle = jnp.arctan2(jnp.where(resting, 0.0, mean_of_others), jnp.where(resting, 1.0, trace))
    if quadrant:
        angle = jnp.clip(angle, 0.0, math.pi / 2)
    away = jnp.abs(angle - sought)
    return jnp.where(resting, 0.0, away) if at_rest == "content" else away

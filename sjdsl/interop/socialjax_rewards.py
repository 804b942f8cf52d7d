"""SocialJax's reward modes at its scale.

All but the common reward are multiplied by the number of agents.
"""

import math
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass

import jax.numpy as jnp
from jax import Array

from sjdsl.trainers.algorithms.shaping import (
    common_mean,
    common_sum,
    exchanged,
    inequity_averse,
    svo_deviation,
)


@dataclass(frozen=True)
class Mode:
    """Keyword arguments that choose the reward, with the suite's names and defaults.

    The first of the flags that is True decides, in this order.
    """

    shared_rewards: bool = True
    inequity_aversion: bool = False
    svo: bool = False
    interest: bool = False
    inequity_aversion_alpha: float = 5.0
    inequity_aversion_beta: float = 0.05
    inequity_aversion_target_agents: Sequence[int] | None = None
    svo_w: float = 0.5
    svo_ideal_angle_degrees: float = 45.0
    svo_target_agents: Sequence[int] | None = None
    s_interest: float = 0.5
    s_interest_schedule: Sequence[float] | None = None
    s_interest_change_every: int = 30_000_000


def make_rewards(
    mode: Mode, num_agents: int, scaled: Collection[str] = ("alone", "shaped"), shared: str = "sum"
) -> Callable[[Array, Array], tuple[Array, dict[str, Array]]]:
    """Returns the function `(raw [N], timestep) -> rewards [N], further infos`.

    While nobody is rewarded, SVO deducts as in the suite, which sets the angle to 0; inequity
    aversion deducts nothing, by its formula.

    Args:
      scaled: which rewards are multiplied by the number of agents: `alone`: those that aren't
        shaped; `shaped`: those that are, before shaping.
      shared: whether agents share the sum of their rewards, or its mean.
    """

    def rewards(raw: Array, timestep: Array) -> tuple[Array, dict[str, Array]]:
        """Returns the shaped rewards `[N]`, and what the suite's info says of them."""
        if mode.shared_rewards:
            return (common_mean(raw) if shared == "mean" else common_sum(raw)), {}
        unshaped = num_agents * raw if "shaped" in scaled else raw
        if mode.inequity_aversion:
            is_target = _is_target(mode.inequity_aversion_target_agents, num_agents)
            shaped = inequity_averse(
                unshaped, unshaped, mode.inequity_aversion_alpha, mode.inequity_aversion_beta
            )
            return jnp.where(is_target, shaped, unshaped), {}
        if mode.svo:
            is_target = _is_target(mode.svo_target_agents, num_agents)
            angle = jnp.float32(math.radians(mode.svo_ideal_angle_degrees))
            deviation = svo_deviation(unshaped, angle, at_rest="selfish", quadrant=False)
            shaped = unshaped - num_agents * mode.svo_w * deviation
            return jnp.where(is_target, shaped, unshaped), {"svo_theta": _angles(unshaped)}
        if mode.interest:
            share = jnp.float32(mode.s_interest)
            if mode.s_interest_schedule is not None:
                schedule = jnp.asarray(mode.s_interest_schedule, jnp.float32)
                period = jnp.asarray(timestep) // mode.s_interest_change_every
                share = schedule[period % len(schedule)]
            return exchanged(unshaped, share), {"s_interest": jnp.broadcast_to(share, raw.shape)}
        return (num_agents * raw if "alone" in scaled else raw), {}

    return rewards


def _is_target(targets: Sequence[int] | None, num_agents: int) -> Array:
    return jnp.asarray([targets is None or agent in targets for agent in range(num_agents)])


def _angles(reward: Array) -> Array:
    """Returns each agent's angle in radians, 0 while nobody is rewarded."""
    others = (reward.sum() - reward) / max(reward.size - 1, 1)
    return jnp.arctan2(others, reward)

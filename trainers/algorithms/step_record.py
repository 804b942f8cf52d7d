"""The record of one environment step from which a user's own reward is computed."""

from typing import Any

import flax
from jax import Array


@flax.struct.dataclass
class Step:
    """One step of one environment."""

    reward: Array  # [N] float32, the game's
    # [N] float32, rewards of the episode so far, decayed by `reward_smoothing` a step; with 0, this
    # step's only
    trace: Array
    action: Array  # [N] int32
    observation: Array  # [N, P, V, V] uint8, acted on
    state: Any  # the environment's, before the action
    # after it, before a new episode begins; None if the environment's info has no `terminal_state`
    next_state: Any
    events: dict[str, Array]  # name -> [N] or [] int32, counts of this step
    metrics: dict[str, Array]  # name -> [] float32, at the end of the step
    done: Array  # [] bool, the episode ends with this step
    truncated: Array  # [] bool, by the time limit

"""What agents with memory also read: their last action and reward, and where trials begin.

With these, a network can learn from trial to trial within an episode, without a gradient. Sources:
Duan et al. 2016, "RL^2: fast reinforcement learning via slow reinforcement learning"; Wang et al.
2016, "Learning to reinforcement learn".
"""

from collections.abc import Iterable, Mapping
from typing import Any

import jax
import jax.numpy as jnp
from jax import Array

from ..environment import trial_ended

# "action": int32, "reward": float32, the game's, "trial": bool, the next step is a trial's first;
# those that `memory_reads` names
LastStep = dict[str, Array]

NO_ACTION = -1  # one-hot, all zeros


def blank_last_step(reads: Iterable[str], shape: tuple[int, ...]) -> LastStep:
    """Returns what agents read in the first step of an episode, of this shape."""
    blank = {
        "action": jnp.full(shape, NO_ACTION, jnp.int32),
        "reward": jnp.zeros(shape, jnp.float32),
        "trial": jnp.ones(shape, bool),
    }
    return {name: blank[name] for name in reads}


def make_last_step(
    reads: Iterable[str], action: Array, reward: Array, info: Mapping[str, Any]
) -> LastStep:
    """Returns what agents read after actions and raw rewards `[B, N]`; `info` is of that step."""
    last = {
        "action": action.astype(jnp.int32),
        "reward": reward.astype(jnp.float32),
        "trial": jnp.broadcast_to(trial_ended(info)[..., None], action.shape),
    }
    return {name: last[name] for name in reads}


def last_step_features(last: LastStep, fresh: Array, num_actions: int, dtype: Any) -> Array:
    """Returns the input of networks, `[L, M, S, K]`: a one-hot action, a reward, 1 or 0 for trials.

    Args:
      last: leaves `[M, L, S]`, the order of a memory's axes.
      fresh: `[L, M]` bool, whether an episode starts with the step.
    Raises:
      ValueError: the memory is of another number of steps.
    """
    num_steps = {leaf.shape[1] for leaf in last.values()}
    if num_steps != {len(fresh)}:
        raise ValueError(
            f"a memory with what agents read in {num_steps} steps can't be used in {len(fresh)}: "
            "see `over_rollout`"
        )
    parts = []
    for name, blank in blank_last_step(last, ()).items():
        leaf = jnp.where(fresh[..., None], blank, jnp.moveaxis(last[name], 1, 0))
        if name == "action":
            parts.append(jax.nn.one_hot(leaf, num_actions, dtype=dtype))
        else:
            parts.append(leaf[..., None].astype(dtype))
    return jnp.concatenate(parts, axis=-1)


def over_rollout(memory: Any, last: LastStep | None) -> Any:
    """Returns the memory before a rollout, with what agents read in each of its T steps.

    Args:
      memory: leaves `[B, G, ...]` of `ActorCritics.start_memory`.
      last: leaves `[T, B, G, 1, S]` of the rollout's `acting`; None if they read nothing.
    """
    if last is None:
        return memory
    of_rollout = {name: jnp.moveaxis(leaf[..., 0, :], 0, 2) for name, leaf in last.items()}
    return memory | {"last": of_rollout}

"""Checks and conversions that all adapters share: seeds, actions, counts by name."""

from collections.abc import Callable, Iterable, Mapping
from typing import Any, TypeVar

import jax
import numpy as np
from jax import Array

from sjdsl.runtime.env import Environment

Value = TypeVar("Value")
KEY_BITS = 32  # of a seed, which `jax.random.key` uses
# Other keys of infos, from an adapter, a library's own wrappers, or JaxMARL's scripts: counts must
# not have these names.
_TAKEN = """
truncated terminated reward rewards original_reward original_rewards shaped_reward
shaped_rewards combined_reward shaped_reward_annealed anneal_factor action_mask active_agent
env_defined_actions terminal_observation final_obs final_observation final_info episode
is_success returned_episode returned_episode_returns returned_episode_lengths
returned_episode_recipe_returns returned_won_episode test_metrics update_step update_steps
updates env_step grad_steps timesteps eps total_loss value_loss actor_loss critic_loss loss
loss_info entropy ratio ratio0 ratio_0 approx_kl clip_frac qvals
"""
TAKEN = frozenset(_TAKEN.split())


def checked_seed(seed: Any) -> int | None:
    """Returns a seed as an `int`; None stays None.

    Raises:
      TypeError: it isn't a whole number. ValueError: it is negative.
    """
    if seed is None:
        return None
    if isinstance(seed, bool) or not isinstance(seed, int | np.integer):
        raise TypeError(f"the seed must be a whole number of 0 or more, not {seed!r}")
    if seed < 0:
        raise ValueError(f"the seed must be a whole number of 0 or more, not {seed}")
    return int(seed)


def seeded_key(seed: Any) -> Array:
    """Returns the key of a seed, using all of its bits; for None, a fresh random key.

    Raises the errors of `checked_seed`.
    """
    number = checked_seed(seed)
    if number is None:
        number = int(np.random.SeedSequence().generate_state(1)[0])
    key = jax.random.key(number % 2**KEY_BITS)
    while number := number >> KEY_BITS:
        key = jax.random.fold_in(key, np.uint32(number % 2**KEY_BITS))
    return key


def numbers_of_actions(
    actions: Iterable[Any], num_actions: int, name: Callable[[int], str]
) -> np.ndarray:
    """Returns actions, one for each agent, as `[S]` int32.

    Args:
      actions: whole numbers, or arrays of a single one.
      name: returns the words for an agent's number in a message, such as ` of player 1`.
    Raises:
      TypeError: one isn't a whole number. ValueError: one is out of range.
    """
    if isinstance(actions, np.ndarray) and actions.ndim == 1:
        arrays = [actions]
    else:
        arrays = [np.asarray(action) for action in actions]
    requirement = f"must be a whole number from 0 to {num_actions - 1}"
    for agent, array in enumerate(arrays):
        if not np.issubdtype(array.dtype, np.integer):
            value = array.ravel()[:1].tolist()[0]
            raise TypeError(f"the action{name(agent)} {requirement}, not {value!r}")
    numbers = np.concatenate([array.ravel() for array in arrays])
    (wrong,) = np.nonzero((numbers < 0) | (numbers >= num_actions))
    if len(wrong):
        agent = int(wrong[0])
        raise ValueError(f"the action{name(agent)} {requirement}, not {numbers[agent]}")
    return numbers.astype(np.int32)


def by_name(counts: Mapping[str, Value], kind: str = "events") -> dict[str, Value]:
    """Returns the counts of a step by name.

    A count whose name has another meaning in a library's infos gets the name `events.NAME`.

    Args:
      kind: `events` or `metrics`.
    """
    return {f"{kind}.{name}" if name in TAKEN else name: value for name, value in counts.items()}


def action_masks(env: Environment, state: Any, allowed: Callable[[Any], Array]) -> np.ndarray:
    """Returns which actions each agent may take, `[..., N, A]` bool.

    `allowed` is called only if the rules forbid actions.
    """
    if env.forbids_actions:
        return np.asarray(allowed(state))
    batch = np.shape(state.step)
    return np.ones((*batch, env.num_agents, env.num_actions), bool)

"""What callers of adapters hand over and get back, alike in all of them: seeds, actions, counts by name."""

from collections.abc import Callable, Iterable, Mapping
from typing import Any, TypeVar

import jax
import numpy as np
from jax import Array

from sjdsl.runtime.env import Environment

Value = TypeVar("Value")
WORD = 32  # bits of a seed that `jax.random.key` takes
# What else stands beside the counts of a step in infos: from an adapter, from a library's own wrappers, or from JaxMARL's scripts.
TAKEN = frozenset(
    {
        *("truncated", "terminated", "reward", "rewards", "original_reward", "original_rewards", "shaped_reward", "shaped_rewards"),
        *("combined_reward", "shaped_reward_annealed", "anneal_factor", "action_mask", "active_agent", "env_defined_actions"),
        *("terminal_observation", "final_obs", "final_observation", "final_info", "episode", "is_success"),
        *("returned_episode", "returned_episode_returns", "returned_episode_lengths", "returned_episode_recipe_returns"),
        *("returned_won_episode", "test_metrics", "update_step", "update_steps", "updates", "env_step", "grad_steps", "timesteps", "eps"),
        *("total_loss", "value_loss", "actor_loss", "critic_loss", "loss", "loss_info", "entropy", "ratio", "ratio0", "ratio_0"),
        *("approx_kl", "clip_frac", "qvals"),
    }
)


def checked_seed(seed: Any) -> int | None:
    """Returns a seed as a plain number, None as it is.

    Raises:
      TypeError: it is no whole number. ValueError: it is negative.
    """
    if seed is None:
        return None
    if isinstance(seed, bool) or not isinstance(seed, int | np.integer):
        raise TypeError(f"the seed must be a whole number of 0 or more, not {seed!r}")
    if seed < 0:
        raise ValueError(f"the seed must be a whole number of 0 or more, not {seed}")
    return int(seed)


def seeded_key(seed: Any) -> Array:
    """Returns the key of a seed, of which every bit counts, however large it is; for None a key that nobody has had. Errors: `checked_seed`."""
    number = checked_seed(seed)
    if number is None:
        number = int(np.random.SeedSequence().generate_state(1)[0])
    key = jax.random.key(number % 2**WORD)
    while number := number >> WORD:
        key = jax.random.fold_in(key, np.uint32(number % 2**WORD))
    return key


def numbers_of_actions(actions: Iterable[Any], num_actions: int, name: Callable[[int], str]) -> np.ndarray:
    """Returns actions, one for each agent, as `[S]` int32.

    Args:
      actions: whole numbers, or arrays of a single one.
      name: says whose an action is, after `is no action`.
    Raises:
      TypeError: one is not a whole number. ValueError: there is no such action.
    """
    given = [actions] if isinstance(actions, np.ndarray) and actions.ndim == 1 else [np.asarray(action) for action in actions]
    for place, action in enumerate(given):
        if not np.issubdtype(action.dtype, np.integer):
            raise TypeError(
                f"{action.ravel()[:1].tolist()[0]!r} is no action{name(place)}: actions are whole numbers, 0 .. {num_actions - 1}"
            )
    chosen = np.concatenate([action.ravel() for action in given])
    wrong = (chosen < 0) | (chosen >= num_actions)
    if wrong.any():
        raise ValueError(f"{chosen[wrong][0]} is no action{name(int(wrong.argmax()))}: 0 .. {num_actions - 1}")
    return chosen.astype(np.int32)


def by_name(counts: Mapping[str, Value], kind: str = "events") -> dict[str, Value]:
    """Returns the counts of a step by name; one whose name means something else in a library's infos is `events.NAME`.

    Args:
      kind: `events` or `metrics`.
    """
    return {f"{kind}.{name}" if name in TAKEN else name: value for name, value in counts.items()}


def action_masks(env: Environment, state: Any, allowed: Callable[[Any], Array]) -> np.ndarray:
    """Returns which actions each agent may take, `[..., N, A]` bool; without a `forbid` of the rules nothing is computed."""
    if env.forbids_actions:
        return np.asarray(allowed(state))
    batch = np.shape(state.step)
    return np.ones((*batch, env.num_agents, env.num_actions), bool)

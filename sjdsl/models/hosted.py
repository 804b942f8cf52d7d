"""A policy for loops in Python: some agents are asked in words, the others follow any policy."""

from collections.abc import Callable, Mapping
from itertools import count
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from sjdsl.models.asking import PARALLEL, Ask, ask_policy
from sjdsl.models.policy import HostPolicy
from sjdsl.models.seats import Seats
from sjdsl.runtime.policy import MemoryPolicy, Policy, compiled_actions, with_memory


def hosted_policy(
    env: Any,
    hosts: Mapping[int, HostPolicy],
    others: Policy,
    ask_of: Callable[[int], Ask] = lambda _: ask_policy,
    parallel: int = PARALLEL,
) -> MemoryPolicy:
    """Returns a policy that can't be traced: it plays one episode after the other.

    Args:
      hosts: by agent, those who are asked; all others follow `others`.
      ask_of: returns `ask` of the `Seats` of its first episode, 0, of the next one, and so on.
      parallel: of `Seats`.

    Raises:
      ModelError: the agents of `env` can't be asked.
    """
    traced = with_memory(others)
    act_of_others, tell_others = compiled_actions(env, traced)
    allowed_actions = jax.jit(env.allowed_actions)
    running = np.zeros(1, bool)
    Seats(env, [hosts]).close()  # refuses before anything is played
    numbers = count()

    def act(memory: Any, key: Array, observation: Array, state: Any) -> tuple[Any, Array]:
        """Returns the memory of the others with the seats of those who are asked, and actions."""
        if memory is None:
            memory = traced.start, Seats(env, [hosts], ask_of(next(numbers)), parallel)
        of_others, seats = memory
        of_others, actions = act_of_others(of_others, key, observation, state)
        allowed = np.asarray(allowed_actions(state))
        chosen = seats.choose(np.asarray(observation)[None], allowed[None], running)[0]
        return (of_others, seats), jnp.where(chosen >= 0, chosen, actions)

    def after_step(memory: Any, actions: Array, reward: Array, info: Mapping[str, Any]) -> Any:
        of_others, seats = memory
        is_over = np.asarray(info["terminated"] | info["truncated"])
        trial_ended = np.asarray(info.get("trial_ended", False))
        seats.learn(np.asarray(reward)[None], trial_ended[None], is_over[None])
        if is_over:
            seats.close()
        return tell_others(of_others, actions, reward, info), seats

    return MemoryPolicy(None, act, reads_state=True, after_step=after_step, traced=False)

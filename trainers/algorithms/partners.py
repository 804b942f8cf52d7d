"""Partners: agents that act by a fixed policy while the others learn."""

from dataclasses import dataclass
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
from jax import Array

from sjdsl.runtime.policy import MemoryPolicy, take_actions

from ..devices.data_parallel import own_keys
from ..environment import Environment, where_env


@dataclass(frozen=True)
class Partners:
    """The policy of the agents that are held fixed; `agents` is empty if all learn."""

    agents: tuple[int, ...]
    policy: MemoryPolicy

    def act(
        self,
        env: Environment,
        memory: Any,
        key: Array,
        observation: Array,
        state: Any,
        fresh: Array,
        action: Array,
    ) -> tuple[Any, Array]:
        """Returns their memory, and the actions `[B, N]` of B environments with theirs replaced."""
        num_envs = fresh.shape[0]
        memory = where_env(fresh, self.policy.starts(num_envs), memory)
        keys = own_keys(key, num_envs)
        take = partial(take_actions, env, self.policy)
        memory, taken = jax.vmap(take)(memory, keys, observation, state)
        agents = jnp.asarray(self.agents)
        return memory, action.at[:, agents].set(taken[:, agents])


NOBODY = Partners((), MemoryPolicy((), lambda memory, _, observation: (memory, observation)))

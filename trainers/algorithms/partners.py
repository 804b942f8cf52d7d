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

    def start(self, num_envs: int) -> Any:
        """Returns their memory before the first step of B environments: leaves `[B, ...]`."""
        return self.policy.starts(num_envs)

    def act(
        self,
        env: Environment,
        memory: Any,
        key: Array,
        observation: Array,
        state: Any,
        fresh: Array,
    ) -> tuple[Any, Array]:
        """Returns their memory and the actions `[B, N]` of B environments.

        Only the actions of `agents` are meaningful.
        """
        num_envs = fresh.shape[0]
        memory = where_env(fresh, self.start(num_envs), memory)
        keys = own_keys(key, num_envs)
        take = partial(take_actions, env, self.policy)
        return jax.vmap(take)(memory, keys, observation, state)

    def after_step(self, memory: Any, action: Array, reward: Array, info: dict[str, Any]) -> Any:
        """Returns their memory after B environments were stepped: `MemoryPolicy.after_step`."""
        return jax.vmap(self.policy.after_step)(memory, action, reward, info)

    def in_place(self, action: Array, theirs: Array) -> Array:
        """Returns actions `[..., N]` with those of the partners replaced."""
        agents = jnp.asarray(self.agents)
        return action.at[..., agents].set(theirs[..., agents])


NOBODY = Partners((), MemoryPolicy((), lambda memory, _, observation: (memory, observation)))

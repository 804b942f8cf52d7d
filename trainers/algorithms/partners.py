"""Partners: agents that act by a fixed policy while the others learn."""

from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
from jax import Array

from sjdsl.runtime.policy import MemoryPolicy, take_actions

from ..devices.data_parallel import own_keys
from ..environment import Environment
from ..settings.config import Config, ConfigError


def learning_agents(num_agents: int, config: Config) -> tuple[int, ...]:
    """Returns the numbers of the agents that learn.

    Raises:
      ConfigError: a partner isn't an agent of the game, or no agent is left to learn.
    """
    held = dict(config.partners)
    wrong = [agent for agent in held if agent >= num_agents]
    if wrong:
        raise ConfigError(
            f"`partners` names agent {wrong[0]}; the game has agents 0 to {num_agents - 1}"
        )
    if len(held) == num_agents:
        raise ConfigError(
            f"`partners` holds all {num_agents} agents fixed: leave out at least one, to learn"
        )
    return tuple(agent for agent in range(num_agents) if agent not in held)


@dataclass(frozen=True)
class Partners:
    """The policy of the agents that are held fixed; `agents` is empty if all learn."""

    agents: tuple[int, ...]
    policy: MemoryPolicy

    def start(self, num_envs: int) -> Any:
        """Returns their memory before the first step of B environments: leaves `[B, ...]`."""
        return jax.tree.map(
            lambda leaf: jnp.broadcast_to(leaf, (num_envs, *jnp.shape(leaf))), self.policy.start
        )

    def act(
        self,
        env: Environment,
        memory: Any,
        key: Array,
        observation: Array,
        state: Any,
        fresh: Array,
    ) -> tuple[Any, Array]:
        """Returns their memory and the actions `[B, N]` of B environments; only those of `agents` are meaningful."""
        number = fresh.shape[0]
        start = self.start(number)
        memory = jax.tree.map(
            lambda new, old: jnp.where(fresh.reshape(-1, *[1] * (new.ndim - 1)), new, old),
            start,
            memory,
        )
        keys = own_keys(key, number)
        return jax.vmap(lambda *seen: take_actions(env, self.policy, *seen))(
            memory, keys, observation, state
        )

    def in_place(self, action: Array, theirs: Array) -> Array:
        """Returns actions `[..., N]` with those of the partners replaced."""
        return action.at[..., jnp.asarray(self.agents)].set(theirs[..., jnp.asarray(self.agents)])


NOBODY = Partners((), MemoryPolicy((), lambda memory, _, observation: (memory, observation)))

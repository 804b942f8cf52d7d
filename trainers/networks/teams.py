"""Parameter sharing: agents of one team share a network, and teams are computed together under `vmap`."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from ..algorithms.partners import learning_agents
from ..environment import Environment
from ..settings.config import PPOConfig


@dataclass(frozen=True)
class Teams:
    """G teams of S agents each; a team shares one network."""

    agents: tuple[tuple[int, ...], ...]  # [G][S] numbers of agents

    @property
    def indices(self) -> np.ndarray:
        """`[G, S]` int32."""
        return np.asarray(self.agents, np.int32)


def make_teams(env: Environment, config: PPOConfig) -> Teams:
    """Returns the teams that `sharing` makes of the agents that learn. Raises ConfigError if `partners` don't fit the agents."""
    learning = learning_agents(env.num_agents, config)
    return Teams(
        (learning,) if config.sharing == "shared" else tuple((agent,) for agent in learning)
    )


def over_teams(teams: Teams, apply: Callable[..., Any], agents_axis: int) -> Callable[..., Any]:
    """Returns `apply(parameters, memory, observation, joint, fresh, agents)` for all G teams.

    Args:
      apply: of one team's network; its results have the team's agents on `agents_axis`.
      agents_axis: of observations and results.
    Returns:
      a function of stacked parameters `[G, ...]`, stacked memory, the observations of all N agents, joint and fresh; the agents are those
      of the teams. Its logits and values have G * S agents, team by team.
    """
    number = len(teams.agents)

    def applied(
        parameters: Any, memory: Any, observation: Array, joint: Any, fresh: Array
    ) -> tuple[Any, Array, Array]:
        own, agents = of_team(observation, teams.indices, agents_axis), jnp.asarray(teams.indices)
        if number == 1:  # a batch of one network would cost a loop over its convolutions
            first = jax.tree.map(lambda leaf: leaf[0], (parameters, memory))
            memory, logits, values = apply(*first, own[0], joint, fresh, agents[0])
            return jax.tree.map(lambda leaf: leaf[None], memory), logits, values
        memory, logits, values = jax.vmap(apply, in_axes=(0, 0, 0, None, None, 0))(
            parameters, memory, own, joint, fresh, agents
        )
        return memory, _side_by_side(logits, agents_axis), _side_by_side(values, agents_axis)

    return applied


def of_team(leaf: Array, agents: Any, axis: int) -> Array:
    """Returns `[G, ..., S, ...]`: the entries of each team's agents `[G, S]` in a leaf with all agents on `axis`."""
    number, size = agents.shape
    if number == 1 and size == leaf.shape[axis]:  # one team of everybody, in order
        return leaf[None]
    return jnp.moveaxis(jnp.take(leaf, jnp.asarray(agents), axis=axis), axis, 0)


def _side_by_side(leaf: Array, axis: int) -> Array:
    """Returns `[..., G * S, ...]` for a leaf `[G, ..., S, ...]` that has S on `axis` of each team."""
    leaf = jnp.moveaxis(leaf, 0, axis)
    return leaf.reshape(*leaf.shape[:axis], -1, *leaf.shape[axis + 2 :])


def with_partners(teams: Teams, part: Array, axis: int, num_agents: int) -> Array:
    """Returns the results of all teams with zeros for agents in no team, which don't learn; agents are on `axis`."""
    agents = teams.indices.ravel()
    if agents.size == num_agents:
        return part
    shape = (*part.shape[:axis], num_agents, *part.shape[axis + 1 :])
    return jnp.zeros(shape, part.dtype).at[(slice(None),) * axis + (jnp.asarray(agents),)].set(part)

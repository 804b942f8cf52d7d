"""Parameter sharing: agents of one team share a network, and teams of equal size are computed together under `vmap`."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from .config import ConfigError, PPOConfig
from .environment import Environment
from .partners import learning_agents


@dataclass(frozen=True)
class Bundle:
    """G teams of S agents each; a team shares one network, a bundle one program."""

    agents: tuple[tuple[int, ...], ...]  # [G][S] numbers of agents

    @property
    def indices(self) -> np.ndarray:
        """`[G, S]` int32."""
        return np.asarray(self.agents, np.int32)

    @property
    def team_size(self) -> int:
        """S."""
        return len(self.agents[0])


def bundle_teams(env: Environment, config: PPOConfig) -> tuple[Bundle, ...]:
    """Returns the teams that `sharing` makes of the agents that learn, those of one size together.

    Raises:
      ConfigError: `partners` or `roles` don't fit the agents, or the game has no roles.
    """
    role_of_agent: Sequence[int]
    match config.sharing:
        case "shared":
            role_of_agent = [0] * env.num_agents
        case "per_agent":
            role_of_agent = range(env.num_agents)
        case "by_role":
            role_of_agent = config.roles or getattr(env, "roles", None) or ()
            if not role_of_agent:
                raise ConfigError(f"`{env.name}` gives its agents no lasting roles; list them, one number an agent, such as roles=0,0,1,1")
    if len(role_of_agent) != env.num_agents:
        raise ConfigError(
            f"`roles` must be a number for each of the {env.num_agents} agents of `{env.name}`, not {len(role_of_agent)} numbers"
        )
    learning = learning_agents(env.num_agents, config)
    wanted_roles = sorted({role_of_agent[agent] for agent in learning})
    teams = [tuple(agent for agent in learning if role_of_agent[agent] == wanted) for wanted in wanted_roles]
    by_size = groupby(sorted(teams, key=len), key=len)
    return tuple(Bundle(tuple(group)) for _, group in by_size)


def over_teams(bundle: Bundle, apply: Callable[..., Any], agents_axis: int) -> Callable[..., Any]:
    """Returns `apply(parameters, memory, observation, joint, fresh, agents)` for all G teams of a bundle.

    Args:
      apply: of one team's network; its results have the team's agents on `agents_axis`.
      agents_axis: of observations and results.
    Returns:
      a function of stacked parameters `[G, ...]`, stacked memory, the observations of all N agents, joint and fresh; the agents are the
      bundle's. Its logits and values have G * S agents, team by team.
    """
    number = len(bundle.agents)

    def applied(parameters: Any, memory: Any, observation: Array, joint: Any, fresh: Array) -> tuple[Any, Array, Array]:
        own, agents = of_team(observation, bundle.indices, agents_axis), jnp.asarray(bundle.indices)
        if number == 1:  # a batch of one network would cost a loop over its convolutions
            first = jax.tree.map(lambda leaf: leaf[0], (parameters, memory))
            memory, logits, values = apply(*first, own[0], joint, fresh, agents[0])
            return jax.tree.map(lambda leaf: leaf[None], memory), logits, values
        memory, logits, values = jax.vmap(apply, in_axes=(0, 0, 0, None, None, 0))(parameters, memory, own, joint, fresh, agents)
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


def in_order(bundles: Sequence[Bundle], parts: Sequence[Array], axis: int, num_agents: int) -> Array:
    """Returns the results of all bundles with the agents in order on `axis`; zeros for agents in no bundle, which don't learn."""
    together = jnp.concatenate(parts, axis=axis) if len(parts) > 1 else parts[0]
    agents = np.concatenate([bundle.indices.ravel() for bundle in bundles])
    if agents.size < num_agents:
        shape = (*together.shape[:axis], num_agents, *together.shape[axis + 1 :])
        return jnp.zeros(shape, together.dtype).at[(slice(None),) * axis + (jnp.asarray(agents),)].set(together)
    if (agents == np.arange(agents.size)).all():
        return together
    return jnp.take(together, jnp.asarray(np.argsort(agents)), axis=axis)

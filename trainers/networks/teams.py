"""Parameter sharing: the agents of a team share a network, and teams are computed side by side."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from ..environment import Environment
from ..settings.config import Config, ConfigError, PPOConfig


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


def make_teams(env: Environment, config: PPOConfig) -> np.ndarray:
    """Returns the numbers of the agents of G teams, `[G, S]` int32: those that learn, as shared.

    Raises:
      ConfigError: `partners` don't fit the agents.
    """
    learning = np.asarray(learning_agents(env.num_agents, config), np.int32)
    return learning[None] if config.sharing == "shared" else learning[:, None]


def over_teams(
    function: Callable[..., Any],
    number: int,
    in_axes: Sequence[int | None],
    out_axes: Sequence[int],
) -> Callable[..., Any]:
    """Returns `jax.vmap` of a function over teams.

    A single team is computed without: under `vmap`, its convolutions would become a loop.
    """
    if number > 1:
        return jax.vmap(function, tuple(in_axes), tuple(out_axes))

    def alone(*arguments: Any) -> Any:
        without_axes = []
        for tree, axis in zip(arguments, in_axes, strict=True):
            if axis is not None:
                tree = jax.tree.map(partial(jnp.squeeze, axis=axis), tree)
            without_axes.append(tree)
        return tuple(
            jax.tree.map(partial(jnp.expand_dims, axis=axis), tree)
            for tree, axis in zip(function(*without_axes), out_axes, strict=True)
        )

    return alone

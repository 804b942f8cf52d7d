"""Roles of agents: which agents play which role, where a game has roles."""

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

EPISODES = 8  # that must begin alike: chance roles of two agents would pass once in 2^7 games at most


def lasting_roles(attribute: str, reset: Callable[[Array], Any]) -> tuple[int, ...] | None:
    """Returns the number of each agent's role; None if it is drawn.

    Args:
      attribute: of the state, that holds the roles and that no step writes.
      reset: key to the first state of an episode.
    """
    states = jax.vmap(reset)(jax.vmap(jax.random.key)(jnp.arange(EPISODES)))
    roles = np.asarray(getattr(states, attribute))
    return tuple(int(role) for role in roles[0]) if (roles == roles[0]).all() else None

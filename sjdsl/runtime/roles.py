"""Which agents play which role, where a game says so."""

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from sjdsl.compiler import ir
from sjdsl.compiler.ir.names import attribute_name

FIELD = "role"
EPISODES = 8  # that must begin alike: chance roles of two agents would pass once in 2^7 games at most


def lasting_roles(game: ir.Game, reset: Callable[[Array], Any]) -> tuple[int, ...] | None:
    """Returns the word number of each agent's field `role`; None if agents have none, a phase writes it, or it is drawn.

    Args:
      game: the typed rules.
      reset: key to the first state of an episode.
    """
    fields = [field for field in game.agents.fields if field.name == FIELD and field.type.kind == "word" and not field.type.by]
    if not fields or any(_writes_role(phase) for phase in game.schedule):
        return None
    states = jax.vmap(reset)(jax.vmap(jax.random.key)(jnp.arange(EPISODES)))
    roles = np.asarray(getattr(states, attribute_name(fields[0])))
    return tuple(int(role) for role in roles[0]) if (roles == roles[0]).all() else None


def _writes_role(phase: ir.Node) -> bool:
    """Whether a phase of the schedule sets a field `role`."""
    return any(isinstance(node, ir.Set) and any(_is_role(part) for part in ir.walk(node.target)) for node in ir.walk(phase))


def _is_role(node: ir.Node) -> bool:
    return isinstance(node, ir.FieldRead) and node.name == FIELD and node.place == "agent"

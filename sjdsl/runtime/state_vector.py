"""The whole state as a vector of numbers, for central critics."""

from typing import Any

import jax
import jax.numpy as jnp
from jax import Array

from sjdsl.runtime.actions import HEADINGS
from sjdsl.runtime.bits import WIDTH, unpack
from sjdsl.runtime.fields import StateField
from sjdsl.runtime.module import GameModule
from sjdsl.runtime.rows import on_last_axis


def state_vector(module: GameModule, state: Any, row: Array, col: Array, length: Array) -> Array:
    """Returns the state as one vector, its entries from -1 to 1.

    In this order: the share of the episode that is over; for each agent its row and column as
    shares of the map, whether it is on the map, and its heading; then every declared field, those
    of cells, of agents, of movers and of the world. An enum value is one-hot. A number with limits
    is scaled to 0 .. 1, and one without, such as a timer x, to x / (1 + |x|). A set of agents and a
    field with one agent have an entry for each agent. Before the fields of a type of mover stands
    where its movers are: whether each is on the map, its row and its column as shares of the map.
    Marks, which last one step, are left out.

    Args:
      module: the generated code, of which MAP, PAD, FRAME, FIELDS and NUM_AGENTS are read.
      state: of one environment.
      row, col: `[N]` int32 on the map, negative for agents who are away.
      length: steps of the episode.
    Returns:
      `[K]` float32.
    """
    present = row >= 0
    height = len(module.MAP)
    width = len(module.MAP[0])
    parts = [
        state.step.astype(jnp.float32) / jnp.asarray(length, jnp.float32),
        jnp.where(present, row, 0).astype(jnp.float32) / jnp.float32(max(height - 1, 1)),
        jnp.where(present, col, 0).astype(jnp.float32) / jnp.float32(max(width - 1, 1)),
        present.astype(jnp.float32),
        jax.nn.one_hot(state.heading, len(HEADINGS), dtype=jnp.float32),
    ]
    for field in module.FIELDS:
        parts.append(_numbers(getattr(state, field.attribute), field, module))
    return jnp.concatenate([part.ravel() for part in parts])


def _side_by_side(*entries: Array) -> Array:
    """Returns several entries of each of a field's values on a new last axis, float32."""
    return jnp.stack([entry.astype(jnp.float32) for entry in entries], axis=-1)


def _numbers(stored: Array, field: StateField, module: GameModule) -> Array:
    """Returns the entries of one field, float32."""
    num_agents = module.NUM_AGENTS
    match field.encoding:
        case "word":
            return jax.nn.one_hot(stored, field.size, dtype=jnp.float32)
        case "agent":
            return jax.nn.one_hot(stored, num_agents, dtype=jnp.float32)  # nobody, -1: all zero
        case "agents":
            if num_agents > WIDTH:
                members: Array = unpack(stored, num_agents)
                return members.astype(jnp.float32)
            shifts = jnp.arange(num_agents).astype(stored.dtype)
            one = jnp.ones((), stored.dtype)
            bits = (stored[..., None] >> on_last_axis(shifts, stored.ndim + 1)) & one
            return bits.astype(jnp.float32)
        case "cell":
            exists = stored >= 0
            row = (stored >> 8) / 255
            col = (stored & 255) / 255
            return _side_by_side(exists, row * exists, col * exists)
        case "place":
            exists = stored > 0
            _, cols = module.FRAME
            row = (stored // cols - module.PAD) / max(len(module.MAP) - 1, 1)
            col = (stored % cols - module.PAD) / max(len(module.MAP[0]) - 1, 1)
            return _side_by_side(exists, jnp.where(exists, row, 0), jnp.where(exists, col, 0))
        case "condition":
            return stored.astype(jnp.float32)
        case "number":
            value = stored.astype(jnp.float32)
            if field.low is None or field.high is None:
                return value / (1.0 + jnp.abs(value))
            result: Array = (value - jnp.float32(field.low)) / jnp.float32(field.high - field.low)
            return result

"""Counts members near each cell, members of sets, and which cells are occupied."""

from functools import partial

import jax
import jax.numpy as jnp
from jax import Array, lax

from sjdsl.runtime.bits import count, pack


def count_near(member: Array, masks: Array) -> Array:
    """Returns how many members each cell has near it.

    Args:
      member: `[M]` bool.
      masks: `[W, S]` uint32 of `geometry.near_masks`.
    Returns:
      `[S]` int32.
    """
    near = lax.population_count(pack(member)[:, None] & masks)
    return jnp.sum(near.astype(jnp.int32), axis=0, dtype=jnp.int32)


def size_of_set(members: Array) -> Array:
    """Returns how many agents sets have that are kept as bits: `[...]` unsigned -> `[...]` int32."""
    return lax.population_count(members).astype(jnp.int32)


def size_of_large_set(words: Array) -> Array:
    """Returns how many agents sets have that are kept as bits in several words: `[..., W]` uint32 -> `[...]` int32."""
    return count(words)


@partial(jax.jit, static_argnums=1)  # one function of the program for each shape, however many rules count
def times_in(sets: Array, agents: int) -> Array:
    """Returns how many of the sets each agent is in.

    The sets are put into rows of 32 and added row by row, then along the last row. XLA compiles this to vector instructions, but not
    a sum along all sets (docs/performance.md).

    Args:
      sets: any shape, unsigned; bit i for agent i.
      agents: at most as many as the sets have bits.
    Returns:
      `[agents]` int32.
    """
    flat = sets.reshape(-1)
    rows, rest = divmod(flat.size, _LANES)
    small = jnp.uint8 if rows < 256 else jnp.int32  # what holds as many as there are rows
    agent = jnp.arange(agents, dtype=flat.dtype)[:, None]

    def members(some: Array) -> Array:
        result: Array = ((some[None] >> agent) & flat.dtype.type(1)).astype(small)
        return result

    counts = jnp.zeros(agents, jnp.int32)
    if rows:
        by_lane = sum((members(flat[row * _LANES : (row + 1) * _LANES]) for row in range(1, rows)), start=members(flat[:_LANES]))
        counts = counts + jnp.sum(by_lane, axis=1, dtype=jnp.int32)
    if rest:
        counts = counts + jnp.sum(members(flat[rows * _LANES :]), axis=1, dtype=jnp.int32)
    return counts


_LANES = 32  # bytes of a vector register


@partial(jax.jit, static_argnums=1)  # as above
def occupied(site: Array, size: int) -> Array:
    """Returns which cells have an agent on them: `[size]` bool, from `[N]` cell numbers (`size` for elsewhere)."""
    return jnp.zeros(size, bool).at[site].set(True, mode="drop", wrap_negative_indices=False)

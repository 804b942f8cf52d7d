"""Counting members near each cell and of sets by bits, and who stands where."""

from functools import partial

import jax
import jax.numpy as jnp
from jax import Array, lax

from sjdsl.runtime.bits import pack


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


def times_in(sets: Array, agents: int) -> Array:
    """Returns how many of the sets each agent is in.

    Eight agents are counted in one word, four bits each, fifteen sets a word; only these words are taken apart. So all that
    the sets come from, a draw each, has one use: XLA computes again for every use what it can fuse.

    Args:
      sets: any shape, unsigned; bit i for agent i.
      agents: at most 32.
    Returns:
      `[agents]` int32.
    """
    flat = sets.reshape(-1)
    counts = []
    for first in range(0, agents, 8):
        fields = _spread((flat >> first).astype(jnp.uint32) & jnp.uint32(0xFF))
        words = lax.reduce_window(fields, jnp.uint32(0), lax.add, (_MOST,), (_MOST,), [(0, -flat.size % _MOST)])
        shifts = 4 * jnp.arange(min(8, agents - first), dtype=jnp.uint32)
        counts.append(jnp.sum((words[None] >> shifts[:, None]) & jnp.uint32(15), axis=1, dtype=jnp.uint32))
    return jnp.concatenate(counts).astype(jnp.int32)


_MOST = 15  # sets that fields of four bits can count


def _spread(byte: Array) -> Array:
    """Returns words with bit i of a byte as bit 4 i: uint32 -> uint32."""
    for shift, kept in ((12, 0x000F000F), (6, 0x03030303), (3, 0x11111111)):
        byte = (byte | byte << jnp.uint32(shift)) & jnp.uint32(kept)
    return byte


@partial(jax.jit, static_argnums=1)  # one function of the program for each size, however many rules ask
def occupied(site: Array, size: int) -> Array:
    """Returns which cells have an agent on them: `[size]` bool, from `[N]` cell numbers (`size` for elsewhere)."""
    return jnp.zeros(size, bool).at[site].set(True, mode="drop")

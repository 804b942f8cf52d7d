"""Counting members near each cell and of sets by bits, and who stands where."""

import functools
import operator

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

    Several agents are counted in one word, a field of bits each: the sum over many sets is what costs.

    Args:
      sets: any shape, unsigned; bit i for agent i.
      agents: at most 32.
    Returns:
      `[agents]` int32.
    """
    # a barrier: XLA would compute what the sets come from (a draw each) again for every word of counts
    flat = lax.optimization_barrier(sets).reshape(-1).astype(jnp.uint32)
    width = flat.shape[0].bit_length()
    together, field = 32 // width, jnp.uint32((1 << width) - 1)
    counts = []
    for first in range(0, agents, together):
        here = range(min(together, agents - first))
        spread = [((flat >> jnp.uint32(first + i)) & jnp.uint32(1)) << jnp.uint32(width * i) for i in here]
        total = jnp.sum(functools.reduce(operator.or_, spread), dtype=jnp.uint32)
        counts += [(total >> jnp.uint32(width * i)) & field for i in here]
    return jnp.stack(counts).astype(jnp.int32)


def occupied(site: Array, size: int) -> Array:
    """Returns which cells have an agent on them: `[size]` bool, from `[N]` cell numbers (`size` for elsewhere)."""
    return jnp.zeros(size, bool).at[site].set(True, mode="drop")

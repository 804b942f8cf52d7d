"""Counting members near each cell by bits, and who stands where."""

import jax.numpy as jnp
import numpy as np
from jax import Array, lax


def near_masks(neighbours: np.ndarray, size: int) -> np.ndarray:
    """Returns `[ceil(size / 32), S]` uint32: bit k of word w is set if cell 32 w + k is a neighbour.

    Args:
      neighbours: `[S, K]` int, numbers of the neighbours, `size` for none.
      size: number of cells that can be neighbours.
    """
    masks = np.zeros((-(-size // 32), len(neighbours)), np.uint32)
    for site, row in enumerate(neighbours):
        for other in row[row < size]:
            masks[other // 32, site] |= np.uint32(1) << np.uint32(other % 32)
    return masks


def count_near(member: Array, masks: np.ndarray) -> Array:
    """Returns how many members each cell has near it.

    Args:
      member: `[M]` bool.
      masks: `[W, S]` uint32 of `near_masks`.
    Returns:
      `[S]` int32.
    """
    padded = lax.pad(member, jnp.asarray(False), [(0, masks.shape[0] * 32 - member.shape[0], 0)])
    bits = padded.reshape(-1, 32).astype(jnp.uint32) << jnp.arange(32, dtype=jnp.uint32)[None]
    packed = jnp.sum(bits, axis=1, dtype=jnp.uint32)
    near = lax.population_count(packed[:, None] & jnp.asarray(masks))
    return jnp.sum(near.astype(jnp.int32), axis=0, dtype=jnp.int32)


def occupied(site: Array, size: int) -> Array:
    """Returns which cells have an agent on them: `[size]` bool, from `[N]` cell numbers (`size` for elsewhere)."""
    return jnp.zeros(size, bool).at[site].set(True, mode="drop")

"""Line of sight at run time: where a beam ends at cells whose state decides it, and whom it meets.

For cells that always end beams, see `geometry.lane_reach`.
"""

import jax.numpy as jnp
import numpy as np
from jax import Array

from sjdsl.runtime.bits import WIDTH, as_bits
from sjdsl.runtime.reductions import any_of, argmax_of
from sjdsl.runtime.rows import on_last_axis


def reached(blocked: Array, on_map: Array, first: Array | np.ndarray) -> Array:
    """Returns which cells of a shape are on the map and not behind a cell that ends their lane.

    All cells are computed at once, on bits if they fit into 32: a loop over cells would be a
    program many times as long.

    Args:
      blocked: `[..., K]` bool, cells that are the last of their lane.
      on_map: `[..., K]` bool, cells that exist.
      first: `[K]` bool, first cells of the lanes; constant: not traced.
    """
    starts = np.asarray(first)
    ends = blocked & on_map
    cell = np.arange(starts.size)
    lane = np.cumsum(starts)
    # [k, j]: whether j comes before k in the same lane.
    before = (lane[:, None] == lane) & (cell < cell[:, None])
    if starts.size > WIDTH:
        before = before.reshape((1,) * (ends.ndim - 1) + before.shape)
        return on_map & ~any_of(ends[..., None, :] & before, axis=-1)
    bits_before: np.ndarray = (before << cell).sum(axis=1, dtype=np.uint32)
    ends_before = as_bits(ends, jnp.uint32)[..., None] & on_last_axis(bits_before, ends.ndim)
    return on_map & (ends_before == 0)


def nearest_in_lanes(
    eligible: Array, numbers: Array, lanes: tuple[int, ...]
) -> tuple[Array, Array]:
    """Returns the number at the nearest eligible cell of each lane, and which lanes have one.

    Args:
      eligible: `[..., K]` bool, of the cells of the shape: lane by lane, the nearest first.
      numbers: `[..., K]`, of the same cells.
      lanes: how many cells each of the L lanes has.

    Returns:
      `[..., L]` of the dtype of `numbers`, undefined in lanes without an eligible cell, and
      `[..., L]` bool.
    """
    shape = (*eligible.shape[:-1], len(lanes), max(lanes))
    if min(lanes) != max(lanes):  # shorter lanes are padded with cells that aren't eligible
        ends = np.cumsum(lanes)[:, None]
        starts = ends - np.array(lanes)[:, None]
        cell = starts + np.arange(max(lanes))
        padded = np.minimum(cell, ends - 1).reshape(-1)
        is_in_lane = on_last_axis((cell < ends).reshape(-1), eligible.ndim)
        eligible = eligible[..., padded] & is_in_lane
        numbers = numbers[..., padded]
    eligible = eligible.reshape(shape)
    numbers = numbers.reshape(shape)
    nearest = argmax_of(eligible, axis=-1)[..., None]
    chosen = jnp.take_along_axis(numbers, nearest, axis=-1, mode="promise_in_bounds")
    return chosen[..., 0], any_of(eligible, axis=-1)

"""Line of sight at run time: where a beam ends at cells whose state decides it (constant walls: `geometry.lane_reach`), and whom it meets."""

import jax.numpy as jnp
import numpy as np
from jax import Array

from sjdsl.runtime.bits import WIDTH, as_bits
from sjdsl.runtime.reductions import any_of, argmax_of


def reached(blocked: Array, on_map: Array, first: Array | np.ndarray) -> Array:
    """Returns which shape cells a lane reaches when some cells end lanes.

    A cell is not reached if one before it in its lane ends the lane. All cells ask at once, of bits where they fit into a word: a walk
    from cell to cell would be a program many times as long.

    Args:
      blocked: `[..., K]` bool, cells that are the last of their lane.
      on_map: `[..., K]` bool, cells that exist.
      first: `[K]` bool, first cells of the lanes; constant: not traced.
    """
    starts, ends = np.asarray(first), blocked & on_map
    cell, lane = np.arange(starts.size), np.cumsum(starts)
    before = (lane[:, None] == lane) & (
        cell < cell[:, None]
    )  # [k, j]: j comes before k in its lane
    if starts.size > WIDTH:
        return on_map & ~any_of(
            ends[..., None, :] & before.reshape((1,) * (ends.ndim - 1) + before.shape), axis=-1
        )
    asked = np.sum(before << cell, axis=1, dtype=np.uint32).reshape((1,) * (ends.ndim - 1) + (-1,))
    return on_map & ((as_bits(ends, jnp.uint32)[..., None] & asked) == 0)


def nearest_in_lanes(
    eligible: Array, numbers: Array, lanes: tuple[int, ...]
) -> tuple[Array, Array]:
    """Returns the number at the nearest eligible cell of each lane of a shape, and in which lanes there is one.

    Args:
      eligible: `[..., K]` bool, of the cells of the shape: lane by lane, each nearest first.
      numbers: `[..., K]`, of the same cells.
      lanes: how many cells each of the L lanes has.
    Returns:
      `[..., L]` of the dtype of `numbers`, anything in lanes without an eligible cell, and `[..., L]` bool.
    """
    shape = (*eligible.shape[:-1], len(lanes), max(lanes))
    if min(lanes) != max(
        lanes
    ):  # shorter lanes are made as long as the longest, by cells that are not eligible
        ends = np.cumsum(lanes)[:, None]
        cell = ends - np.array(lanes)[:, None] + np.arange(max(lanes))
        eligible = eligible[..., np.minimum(cell, ends - 1).reshape(-1)] & (cell < ends).reshape(
            (1,) * (eligible.ndim - 1) + (-1,)
        )
        numbers = numbers[..., np.minimum(cell, ends - 1).reshape(-1)]
    eligible, numbers = eligible.reshape(shape), numbers.reshape(shape)
    nearest = argmax_of(eligible, axis=-1)[..., None]
    chosen: Array = jnp.take_along_axis(numbers, nearest, axis=-1, mode="promise_in_bounds")[..., 0]
    return chosen, any_of(eligible, axis=-1)

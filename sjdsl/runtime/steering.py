"""Steering of movers: how much nearer each neighbouring cell is to what they seek or flee."""

from collections.abc import Callable

import jax
import jax.numpy as jnp
from jax import Array

from sjdsl.runtime.actions import DIRECTIONS
from sjdsl.runtime.rows import on_last_axis
from sjdsl.runtime.torus import shorter_way

FAR = 2**20  # more than the steps between any two cells of a map


@jax.jit  # one function of the program for each shape, however many rules move something
def gains(position: Array, cells: Array, member: Array, cols: int) -> Array:
    """Returns how many steps farther from its nearest member each mover is on each cell beside it.

    Steps are counted along rows and columns, whatever stands between: no path is searched.

    Args:
      position: `[M]` int32 in the padded frame.
      cells: `[M, T]` or `[1, T]` int32, where the members are.
      member: `[M, T]` or `[1, T]` bool.
      cols: columns of the frame.
    Returns:
      `[M, 4]` int32, north, east, south, west: negative is nearer; 0 without any member.
    """
    return _gained(position, cells, member, cols, lambda away, _: away)


@jax.jit  # as above
def gains_around(
    position: Array, cells: Array, member: Array, cols: int, height: int, width: int
) -> Array:
    """Returns what `gains` does, on a map of that height and width that wraps."""

    def way(away: Array, axis: int) -> Array:
        return shorter_way(away, (height, width)[axis])

    return _gained(position, cells, member, cols, way)


def _gained(
    position: Array, cells: Array, member: Array, cols: int, way: Callable[[Array, int], Array]
) -> Array:
    """Returns how much farther the nearest member is after a step in each direction.

    Args:
      way: (difference, 0 of rows or 1 of columns) -> the steps to go, with their sign.
    """
    rows_away = cells // cols - position[:, None] // cols
    cols_away = cells % cols - position[:, None] % cols

    def nearest(down: int, right: int) -> Array:
        steps = jnp.abs(way(rows_away - down, 0)) + jnp.abs(way(cols_away - right, 1))
        return jnp.min(jnp.where(member, steps, FAR), axis=1)

    after = jnp.stack([nearest(down, right) for down, right in DIRECTIONS], axis=1)
    return after - nearest(0, 0)[:, None]


def is_one_of(cells: Array, taken: Array) -> Array:
    """Returns which cells are among those taken, bool of the shape of `cells`.

    Args:
      cells: `[...]` int32, or `[M, W]`.
      taken: `[B]` int32, or for each row of `cells`, `[M or 1, 1, B]`.
    """
    if taken.ndim == 1:
        taken = on_last_axis(taken, cells.ndim + 1)
    return jnp.any(cells[..., None] == taken, axis=-1)

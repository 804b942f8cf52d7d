"""Steering of movers: how much nearer each neighbouring cell is to what they seek or flee."""

import jax.numpy as jnp
from jax import Array

from sjdsl.runtime.actions import DIRECTIONS
from sjdsl.runtime.forms import one_function
from sjdsl.runtime.rows import on_last_axis
from sjdsl.runtime.torus import shorter_way

FAR = 2**20  # more than the steps between any two cells of a map


@one_function
def gains(
    position: Array,
    cells: Array,
    member: Array,
    cols: int,
    around: tuple[int, int] | None = None,
) -> Array:
    """Returns how many steps farther from its nearest member each mover is on each cell beside it.

    Steps are counted along rows and columns, whatever stands between: no path is searched.

    Args:
      position: `[M]` int32 in the padded frame.
      cells: `[M, T]` or `[1, T]` int32, where the members are.
      member: `[M, T]` or `[1, T]` bool.
      cols: columns of the frame.
      around: height and width of a map that wraps, None for other maps.
    Returns:
      `[M, 4]` int32, north, east, south, west: negative is nearer; 0 without any member.
    """
    rows_away = cells // cols - position[:, None] // cols
    cols_away = cells % cols - position[:, None] % cols

    def steps_to_nearest(down: int, right: int) -> Array:
        """Returns the steps to the nearest member, for movers that have gone so far: `[M]`."""
        rows = rows_away - down
        cols = cols_away - right
        if around is not None:
            height, width = around
            rows = shorter_way(rows, height)
            cols = shorter_way(cols, width)
        steps = jnp.abs(rows) + jnp.abs(cols)
        return jnp.min(jnp.where(member, steps, FAR), axis=1)

    after = [steps_to_nearest(down, right) for down, right in DIRECTIONS]
    before = steps_to_nearest(0, 0)
    return jnp.stack(after, axis=1) - before[:, None]


def is_one_of(cells: Array, taken: Array) -> Array:
    """Returns which cells are among those taken, bool of the shape of `cells`.

    Args:
      cells: `[...]` int32, or `[M, W]`.
      taken: `[B]` int32, or for each row of `cells`, `[M or 1, 1, B]`.
    """
    if taken.ndim == 1:
        taken = on_last_axis(taken, cells.ndim + 1)
    return jnp.any(cells[..., None] == taken, axis=-1)

"""Maps whose edges are joined: ways round the map, and planes continued beyond its edges."""

import jax.numpy as jnp
from jax import Array

from sjdsl.runtime.actions import DIRECTIONS


def shorter_way(difference: Array, length: int) -> Array:
    """Returns differences of rows or columns the shorter way round, of two equal ways the positive.

    Args:
      difference: `[...]` int32; length: of the map along it.
    Returns:
      `[...]` int32, from more than -length / 2 to length / 2.
    """
    onward = difference % length
    return jnp.where(2 * onward <= length, onward, onward - length)


def cells_on(
    cell: Array, heading: Array, number: Array, height: int, width: int, pad: int
) -> Array:
    """Returns the cells some steps away from others in a direction.

    Args:
      cell: `[...]` int32 in the padded frame; heading: 0 north to 3 west; number: of steps. They
        broadcast.
      height, width: of the map; pad: cells around it on each side.
    """
    cols = width + 2 * pad
    direction = jnp.asarray(DIRECTIONS, jnp.int32)[heading]  # [..., 2] rows down, columns right
    # Rows and columns of the map, without the padding.
    row = (cell // cols - pad + direction[..., 0] * number) % height
    col = (cell % cols - pad + direction[..., 1] * number) % width
    return (row + pad) * cols + col + pad


def joined_edges(plane: Array, pad: int) -> Array:
    """Returns a padded plane `[rows, cols]` whose padding shows the other side of the map."""
    shown = plane[pad:-pad, pad:-pad]
    for axis in (0, 1):
        size = shown.shape[axis]
        # The padding on each side shows so many whole maps, and a part of one.
        whole, rest = divmod(pad, size)
        before = shown[size - rest :] if axis == 0 else shown[:, size - rest :]
        behind = shown[:rest] if axis == 0 else shown[:, :rest]
        shown = jnp.concatenate([before, *[shown] * (2 * whole + 1), behind], axis=axis)
    return shown

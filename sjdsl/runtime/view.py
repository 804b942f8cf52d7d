"""Windows: what each agent sees of the map's planes, cut out and turned so that forward is up."""

import jax
import jax.numpy as jnp
from jax import Array, lax


def windows(plane: Array, position: Array, heading: Array, *, ahead: int, behind: int, left: int, right: int) -> Array:
    """Returns each agent's window of one plane.

    The plane is turned four ways once; then each window is one slice: the cheapest form measured on a CPU.

    Args:
      plane: `[rows, cols]` of the padded frame; every window lies in it.
      position: `[N]` int32 cells of the frame (nowhere, cell 0: some window, to be masked by the caller).
      heading: `[N]` int32, 0 north .. 3 west.
      ahead, behind, left, right: cells seen to each side.
    Returns:
      `[N, ahead + 1 + behind, left + 1 + right]`; the agent at (ahead, left).
    """
    rows, cols = plane.shape
    side = max(rows, cols)
    turned = []
    for k in range(4):
        view = jnp.rot90(plane, k)
        turned.append(lax.pad(view, jnp.zeros((), plane.dtype), [(0, side - view.shape[0], 0), (0, side - view.shape[1], 0)]))
    planes = jnp.stack(turned)
    row, col = position // cols, position % cols
    # jnp.rot90 turns counter-clockwise: facing east (1), east becomes up
    turned_row = jnp.select([heading == 0, heading == 1, heading == 2], [row, cols - 1 - col, rows - 1 - row], col)
    turned_col = jnp.select([heading == 0, heading == 1, heading == 2], [col, row, cols - 1 - col], rows - 1 - row)
    size = (1, ahead + 1 + behind, left + 1 + right)

    def cut(h: Array, r: Array, c: Array) -> Array:
        return lax.dynamic_slice(planes, (h, r - ahead, c - left), size)[0]

    return jax.vmap(cut)(heading, turned_row, turned_col)


def paint(plane: Array, cells: Array, bits: Array | int) -> Array:
    """Returns a plane with bits added to cells; cells named twice get the bits once, cell 0 (nowhere) too.

    Args:
      plane: `[cells]` uint8.
      cells: `[M]` int32.
      bits: uint8, `[M]` (then the cells differ) or one for all.
    """
    painted = plane[cells] | jnp.asarray(bits, jnp.uint8)
    return plane.at[cells].set(painted, mode="promise_in_bounds")


def planes_of(*planes: Array) -> Array:
    """Returns planes side by side in a last axis: P arrays `[...]` uint8 -> `[..., P]`.

    Packed into words and taken as bytes again: the same values as `jnp.stack`, at two thirds of its time on a CPU.
    """
    shape = planes[0].shape
    words = []
    for first in range(0, len(planes), 4):
        word = jnp.zeros(shape, jnp.uint32)
        for place, plane in enumerate(planes[first : first + 4]):
            word = word | (plane.astype(jnp.uint32) << jnp.uint32(8 * place))
        words.append(lax.bitcast_convert_type(word, jnp.uint8))
    together = words[0] if len(words) == 1 else jnp.concatenate(words, axis=-1)
    return together[..., : len(planes)]

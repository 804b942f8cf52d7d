"""Egocentric windows: cuts each agent's view out of the map's planes, its heading pointing up.

A cell of a plane is a byte. A kind whose cells look different has a number for each combination of
its fields' values, one after the other: `look_number` makes them, `look_fields` takes them apart.
"""

import math
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array, lax
from jax.custom_batching import custom_vmap

from sjdsl.runtime.bits import set_of, unpack
from sjdsl.runtime.forms import by_platform, one_function
from sjdsl.runtime.rows import entries_in_bounds


@partial(one_function, static=("ahead", "behind", "left", "right"))
def windows(
    plane: Array, position: Array, heading: Array, *, ahead: int, behind: int, left: int, right: int
) -> Array:
    """Returns each agent's window of one plane.

    Args:
      plane: `[rows, cols]` of the padded frame; every window lies in it.
      position: `[N]` int32 cells of the frame; for nowhere, cell 0, the window is undefined, and
        the caller masks it.
      heading: `[N]` int32, 0 north .. 3 west.
      ahead, behind, left, right: cells seen to each side.

    Returns:
      `[N, V]`, the cells of each window row by row: `(ahead + 1 + behind) * (left + 1 + right)` of
      them, the agent's own in row `ahead`, column `left`. They are on one axis because XLA makes
      vector instructions of the last axis only, and a row is too short.
    """
    sides = (ahead, behind, left, right)
    cut = partial(_windows_cut, sides=sides)
    looked_up = partial(_windows_looked_up, sides=sides)
    return by_platform(cut, looked_up, plane, position, heading)


def _windows_looked_up(
    plane: Array, position: Array, heading: Array, sides: tuple[int, int, int, int]
) -> Array:
    """The form for GPUs: each cell of each window looks its cell of the plane up, in one kernel."""
    ahead, behind, left, right = sides
    cols = plane.shape[1]
    # Where the cells of a window are from its agent, [V] each: rows down and columns to the right
    # if it faces north; for each heading, the difference of cell numbers.
    row, col = np.mgrid[-ahead : behind + 1, -left : right + 1].reshape(2, -1)
    by_heading = [row * cols + col, col * cols - row, -row * cols - col, -col * cols + row]
    offsets = np.stack(by_heading).astype(np.int32)
    cells = position[:, None] + jnp.asarray(offsets)[heading]
    return entries_in_bounds(plane.reshape(-1), cells)


def _windows_cut(
    plane: Array, position: Array, heading: Array, sides: tuple[int, int, int, int]
) -> Array:
    """The form for CPUs: the plane is turned four ways once; then each window is one slice."""
    ahead, behind, left, right = sides
    rows, cols = plane.shape
    side = max(rows, cols)
    turned = []
    for heading_up in range(4):
        view = jnp.rot90(plane, heading_up)
        edges = [(0, side - view.shape[0], 0), (0, side - view.shape[1], 0)]
        turned.append(lax.pad(view, jnp.zeros((), plane.dtype), edges))
    planes = jnp.stack(turned)
    row = position // cols
    col = position % cols
    # jnp.rot90 turns counter-clockwise: facing east (1), east becomes up
    from_right = cols - 1 - col
    from_below = rows - 1 - row
    turned_row = lax.select_n(heading, row, from_right, from_below, col)
    turned_col = lax.select_n(heading, col, row, from_right, from_below)
    size = (ahead + 1 + behind, left + 1 + right)

    def cut(h: Array, r: Array, c: Array) -> Array:
        return lax.dynamic_slice(planes, (h, r - ahead, c - left), (1, *size))[0]

    seen = jax.vmap(cut)(heading, turned_row, turned_col)
    return seen.reshape(position.size, size[0] * size[1])


def fill(plane: Array, cells: Array | np.ndarray, values: Array) -> Array:
    """Returns a plane with values in some of its cells.

    Args:
      plane: `[cells]` uint8.
      cells: `[S]` int32, ascending; constant: not traced.
      values: `[S]` uint8.
    """
    in_runs = partial(_filled_in_runs, cells)
    by_number = partial(_filled_by_number, cells)
    return by_platform(in_runs, by_number, plane, values)


def _filled_by_number(cells: Array | np.ndarray, plane: Array, values: Array) -> Array:
    """The form for GPUs: each cell of the plane looks up its value.

    XLA transposes lookups by constant numbers, so the numbers are made to depend on the values.
    """
    constant = np.asarray(cells)
    numbers = np.zeros(plane.shape[0], np.int32)
    numbers[constant] = np.arange(constant.size)
    is_filled = np.zeros(plane.shape[0], bool)
    is_filled[constant] = True
    not_constant = jnp.asarray(numbers) + (values[0].astype(jnp.int32) & 0)
    filled = jnp.asarray(is_filled)
    return jnp.where(filled, values.at[not_constant].get(mode="promise_in_bounds"), plane)


def _filled_in_runs(cells: Array | np.ndarray, plane: Array, values: Array) -> Array:
    """The form for CPUs: for a large batch, the plane is assembled from runs of adjacent cells.

    Each run is copied, if runs are long. A scatter cell by cell takes twice as long for 538 cells
    in 81 runs (docs/research/performance.md).
    """
    constant = np.asarray(cells)
    first = np.flatnonzero(np.diff(constant, prepend=-2) != 1)
    if constant.size < LONG_RUN * first.size:
        return _scattered(plane, cells, values)

    def scattered(plane: Array, values: Array) -> Array:
        return _scattered(plane, cells, values)

    filled = custom_vmap(scattered)

    @filled.def_vmap
    def batched(size: int, in_batched: Any, plane: Array, values: Array) -> tuple[Array, bool]:
        """Fills the planes of a batch `[B, cells]`: in a large one, runs of cells are slices."""
        plane_batched, values_batched = in_batched
        if not plane_batched:
            plane = jnp.broadcast_to(plane, (size, *plane.shape))
        if not values_batched:
            values = jnp.broadcast_to(values, (size, *values.shape))
        if size < LARGE_BATCH:
            return jax.vmap(scattered)(plane, values), True
        return _from_runs(plane, values, constant, first), True

    result: Array = filled(plane, values)
    return result


LONG_RUN = 4  # cells of a run, on average: below, copies are not faster
LARGE_BATCH = 16  # environments: below, starting so many copies takes longer than making them


def _scattered(plane: Array, cells: Array | np.ndarray, values: Array) -> Array:
    """Returns a plane with values at distinct cells, which are in order."""
    where = plane.at[cells]
    return where.set(
        values,
        mode="promise_in_bounds",
        wrap_negative_indices=False,
        indices_are_sorted=True,
        unique_indices=True,
    )


def _from_runs(planes: Array, values: Array, cells: np.ndarray, first: np.ndarray) -> Array:
    """Returns `[B, cells]` planes: pieces of the planes and the runs in turn.

    Args:
      first: the number of each run's first cell among `cells`.
    """
    pieces = []
    place = 0  # the first cell of the planes behind the last run
    for begin, end in zip(first, [*first[1:], cells.size], strict=True):
        pieces.append(planes[:, place : cells[begin]])
        pieces.append(values[:, begin:end])
        place = cells[end - 1] + 1
    return jnp.concatenate([*pieces, planes[:, place:]], axis=1)


def paint(plane: Array, cells: Array, bits: Array | int) -> Array:
    """Returns a plane with bits added to cells, to a cell that is named twice only once.

    Cell 0, nowhere, is a cell like others.

    Args:
      plane: `[cells]` uint8.
      cells: `[M]` int32.
      bits: uint8, `[M]` (then the cells differ) or one for all.
    """
    for_gpus = _painted_as_bits if np.ndim(bits) == 0 else _painted_by_comparing
    return by_platform(_painted_by_cell, for_gpus, plane, cells, jnp.asarray(bits, jnp.uint8))


def _painted_as_bits(plane: Array, cells: Array, bits: Array) -> Array:
    """The form for GPUs of one value for all: the cells are kept as bits, 32 in a word."""
    size = plane.shape[0]
    return plane | jnp.where(unpack(set_of(cells, size), size), bits, jnp.uint8(0))


def _painted_by_comparing(plane: Array, cells: Array, bits: Array) -> Array:
    """The form for GPUs of a value for each cell: each cell of the plane is compared with all."""
    number = jnp.arange(plane.shape[0], dtype=jnp.int32)
    painted = jnp.zeros_like(plane)
    for place in range(cells.shape[0]):
        painted = jnp.where(number == cells[place], bits[place], painted)
    return plane | painted


def _painted_by_cell(plane: Array, cells: Array, bits: Array) -> Array:
    """The form for CPUs: a scatter."""
    painted = entries_in_bounds(plane, cells) | bits
    where = plane.at[cells]
    return where.set(painted, mode="promise_in_bounds", wrap_negative_indices=False)


def look_number(first: int, sizes: tuple[int, ...], *values: Array) -> Array:
    """Returns the numbers of looks.

    Args:
      first: the first number of the kind.
      sizes: how many values each field has, the slowest first.
      values: one array of whole numbers a field, 0 .. its size - 1; of shapes that fit together.
    Returns:
      uint8 of the shape of all of them.
    """
    number = values[0].astype(jnp.uint8)
    for size, value in zip(sizes[1:], values[1:], strict=True):
        number = number * size + value.astype(jnp.uint8)
    return number + first


def look_fields(number: Array, first: int, sizes: tuple[int, ...]) -> tuple[Array, ...]:
    """Returns which numbers are looks of a kind, and the value of each of its fields.

    Args:
      number: any shape, uint8.
      first, sizes: as of `look_number`.

    Returns:
      bool, and for each field uint8, undefined where the number is no look of the kind; all of the
      shape of `number`.
    """
    is_look = (number >= first) & (number <= first + math.prod(sizes) - 1)  # 256 is no byte
    rest = number - first
    values: list[Array] = []
    for size in reversed(sizes[1:]):
        values.append(rest % size)
        rest = rest // size
    return is_look, rest, *reversed(values)


def planes_of(view: tuple[int, int], present: Array | None, *planes: Array) -> Array:
    """Returns the planes of all windows, each plane contiguous.

    Interleaved bytes of several planes would be written one by one, which takes ten times as long
    on a CPU (docs/research/performance.md).

    Args:
      view: rows and columns of a window.
      present: `[N]` bool, who is on the map; the others see zeros. None: all are.
      planes: arrays `[N, rows * columns]` uint8, or several planes of that size side by side; P
        planes together.

    Returns:
      `[N, P, rows, columns]` uint8.
    """
    together = jnp.concatenate(planes, axis=1)
    if present is not None:
        together = jnp.where(present[:, None], together, jnp.uint8(0))
    number, values = together.shape
    return together.reshape(number, values // (view[0] * view[1]), *view)

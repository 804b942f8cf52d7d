"""Reads fields of the cells around each cell: as shifted copies if possible, else by index."""

from collections.abc import Callable, Iterator, Sequence
from functools import reduce
from typing import Literal

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from sjdsl.runtime.rows import entries_in_bounds

Fold = Literal["sum", "max", "min", "any"]
_FOLDS: dict[str, Callable[[Array, Array], Array]] = {
    "sum": jnp.add,
    "max": jnp.maximum,
    "min": jnp.minimum,
    "any": jnp.logical_or,
}


def looked_up(values: Array, cells: Array) -> Array:
    """Returns `values[cells]`, where each value is computed once.

    XLA for CPUs computes an indexed value again for every index, be it the 20 rounds of a random
    number; it doesn't if the values are concatenated (docs/research/performance.md).

    Args:
      values: `[S, ...]`.
      cells: any shape, int32; the result is undefined for S, one past the end.
    """
    return entries_in_bounds(jnp.concatenate([values, values[:1]]), cells)


def entries_at(table: Array, places: Array) -> Array:
    """Returns one entry of each row, computed once, however often it is read.

    Args:
      table: `[S, K]`.
      places: `[S]` int32, below K.

    Returns:
      `[S]`.
    """
    entries: Array = jnp.take_along_axis(table, places[:, None], axis=1)[:, 0]
    return looked_up(entries, jnp.arange(len(entries), dtype=jnp.int32))


def over_neighbours(
    fold: Fold,
    table: Array,
    of_cell: Callable[..., Array],
    *fields: Array,
    around: Array | None = None,
) -> Array:
    """Returns a sum, maximum, minimum or disjunction of `of_cell` over the cells around each cell.

    The function is applied once for each cell of the shape, to all cells at once. If the cells fill
    a rectangle, their fields are shifted copies, for which XLA has vector instructions; it has none
    for lookups (docs/research/performance.md).

    Args:
      fold: how values are combined; a sum of booleans counts them.
      table: `[S, K]` int32, constant: the indices of the cells around each cell, past the end for
        none.
      of_cell: `(indices [C], a field [C] for each of fields) -> [C]`, bool or int32; fields are
        undefined for indices past the end.
      fields: `[M, ...]` each, by the indices in the table.
      around: `[C]` int32, the rows of the table to use, None for all: C = S.

    Returns:
      `[C]` int32, or bool for `any`.
    """
    numbers = np.asarray(table)
    cells = _beside(numbers, fields) if around is None else _beside_some(numbers, fields, around)
    count = jnp.uint8 if numbers.shape[1] < 256 else jnp.int32

    @jax.jit  # one function of the program, called for each cell of the shape; XLA inlines it
    def once(*cell: Array) -> Array:
        value = of_cell(*cell)
        if fold == "sum" and value.dtype == bool:
            value = value.astype(count)
        return value

    values: list[Array] = [once(*cell) for cell in cells]
    result = reduce(_FOLDS[fold], values)
    return result if result.dtype == bool else result.astype(jnp.int32)


def _beside(numbers: np.ndarray, fields: Sequence[Array]) -> Iterator[tuple[Array, ...]]:
    """Yields for each cell of the shape the numbers of those cells around all, and their fields.

    Args:
      numbers: `[S, K]`, the table of `over_neighbours`; K cells of the shape.
    """
    steps = _steps(numbers, len(fields[0]))
    if steps is None or len(fields[0]) != len(numbers):
        for column in map(jnp.asarray, numbers.T):
            yield column, *(looked_up(values, column) for values in fields)
        return
    # Around each field stands its other end, so that every shifted copy is one slice.
    reach = max(1, *map(abs, steps))
    rings = [jnp.concatenate([values[-reach:], values, values[:reach]]) for values in fields]
    for column, step in zip(numbers.T, steps, strict=True):
        first = reach + step
        yield jnp.asarray(column), *(ring[first : first + len(numbers)] for ring in rings)


def _beside_some(
    numbers: np.ndarray, fields: Sequence[Array], around: Array
) -> Iterator[tuple[Array, ...]]:
    """Yields what `_beside` does, around some cells only."""
    size = len(fields[0])
    steps = _steps(numbers, size)
    padded = [jnp.concatenate([values, values[:1]]) for values in fields]  # an entry for `size`
    # Whether there is a cell at each place of the shape, as the bits of a word for each cell.
    bits = (numbers < size) << np.arange(numbers.shape[1], dtype=np.uint32)
    exists = jnp.asarray(np.sum(bits, axis=1, dtype=np.uint32))[around]

    @jax.jit
    def beside(place: int, step: int) -> Array:
        return jnp.where((exists >> place) & 1 == 1, around + step, size)

    for place, column in enumerate(numbers.T):
        if steps is None:
            number = jnp.asarray(column)[around]
        else:
            number = beside(place, steps[place])
        yield number, *(entries_in_bounds(values, number) for values in padded)


def _steps(numbers: np.ndarray, size: int) -> list[int] | None:
    """Returns, for each cell of the shape, its number minus that of the cell in the middle.

    It is None if such a difference isn't the same around all cells, or is larger than the number of
    cells.
    """
    if numbers.shape[1] > 32:
        return None
    steps = []
    for column in numbers.T:
        cells = np.flatnonzero(column < size)
        differences = np.unique(column[cells] - cells)
        if len(differences) > 1 or np.any(abs(differences) > size):
            return None
        steps.append(int(differences[0]) if len(differences) else 0)
    return steps

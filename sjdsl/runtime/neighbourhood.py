"""Reads fields of the cells around each cell: as shifted copies where the map is a full rectangle, else by number."""

from collections.abc import Callable, Iterator, Sequence
from functools import reduce
from typing import Literal

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

Fold = Literal["sum", "max", "min", "any"]
_FOLDS: dict[str, Callable[[Array, Array], Array]] = {
    "sum": jnp.add,
    "max": jnp.maximum,
    "min": jnp.minimum,
    "any": jnp.logical_or,
}


def looked_up(values: Array, cells: Array) -> Array:
    """Returns the entry of each of many cells: `values[cells]`, but what computes the values is computed once for each of them.

    XLA for CPUs computes what is indexed anew for every index, be it the 20 rounds of a random number. It does so for no
    concatenation (docs/performance.md).

    Args:
      values: `[S, ...]`.
      cells: any shape, int32; past the end: the entry means nothing.
    """
    entries: Array = (
        jnp.concatenate([values, values[:1]])
        .at[cells]
        .get(mode="promise_in_bounds", wrap_negative_indices=False)
    )
    return entries


def entries_at(table: Array, places: Array) -> Array:
    """Returns the entry of each row at a place of its own, computed once for all who look something up by it.

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
    """Returns the sum, greatest, least or disjunction, over the cells around each cell, of what `of_cell` computes.

    The function is applied once for each cell of the shape, to all cells at once. Where the cells have numbers in a full rectangle,
    their fields are shifted copies, of which XLA makes vector instructions; it makes none of lookups by numbers (docs/performance.md).

    Args:
      fold: what is done with the values; a sum of booleans counts them.
      table: `[S, K]` int32, constant: the numbers of the cells around each cell; past the end: none.
      of_cell: `(numbers [C], a field [C] for each of fields) -> [C]`, bool or int32; of numbers past the end the fields mean nothing.
      fields: `[M, ...]` each, by the numbers in the table.
      around: `[C]` int32, the rows of the table that are asked for; None: all, C = S.
    Returns:
      `[C]` int32, or bool of `any`.
    """
    numbers = np.asarray(table)
    cells = _beside(numbers, fields) if around is None else _beside_some(numbers, fields, around)
    count = jnp.uint8 if numbers.shape[1] < 256 else jnp.int32

    @jax.jit  # one function in the program, called for each cell of the shape; XLA puts it in place
    def once(*cell: Array) -> Array:
        value = of_cell(*cell)
        if fold == "sum" and value.dtype == bool:
            value = value.astype(count)
        return value

    values: list[Array] = [once(*cell) for cell in cells]
    result = reduce(_FOLDS[fold], values)
    return result if result.dtype == bool else result.astype(jnp.int32)


def _beside(numbers: np.ndarray, fields: Sequence[Array]) -> Iterator[tuple[Array, ...]]:
    """Yields, for one cell of the shape after another, its number beside each cell, and its fields."""
    steps = _steps(numbers, len(fields[0]))
    if steps is None or len(fields[0]) != len(numbers):
        for column in numbers.T:
            yield (
                jnp.asarray(column),
                *(looked_up(values, jnp.asarray(column)) for values in fields),
            )
        return
    reach = max(1, *map(abs, steps))
    rings = [jnp.concatenate([values[-reach:], values, values[:reach]]) for values in fields]
    for column, step in zip(numbers.T, steps, strict=True):
        yield (
            jnp.asarray(column),
            *(ring[reach + step : reach + step + len(numbers)] for ring in rings),
        )


def _beside_some(
    numbers: np.ndarray, fields: Sequence[Array], around: Array
) -> Iterator[tuple[Array, ...]]:
    """Yields the same for some cells."""
    size = len(fields[0])
    steps = _steps(numbers, size)
    longer = [jnp.concatenate([values, values[:1]]) for values in fields]
    there = jnp.asarray(
        np.sum(
            (numbers < size) << np.arange(numbers.shape[1], dtype=np.uint32),
            axis=1,
            dtype=np.uint32,
        )
    )[around]

    @jax.jit
    def beside(place: int, step: int) -> Array:
        return jnp.where((there >> place) & 1 == 1, around + step, size)

    for place, column in enumerate(numbers.T):
        number = jnp.asarray(column)[around] if steps is None else beside(place, steps[place])
        yield (
            number,
            *(
                values.at[number].get(mode="promise_in_bounds", wrap_negative_indices=False)
                for values in longer
            ),
        )


def _steps(numbers: np.ndarray, size: int) -> list[int] | None:
    """Returns how far the cells of the shape are, by number, if each is as far from all cells that have it and less than all cells are."""
    found = [
        np.unique(column[there] - there)
        for column in numbers.T
        for there in [np.flatnonzero(column < size)]
    ]
    if numbers.shape[1] > 32 or any(len(steps) > 1 or np.any(abs(steps) > size) for steps in found):
        return None
    return [int(steps[0]) if len(steps) else 0 for steps in found]

"""Sums over the cells around each cell, against loops in Python; on full rectangles and on maps with holes."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from sjdsl.runtime.geometry import cells_of, neighbours, shape_offsets, site_numbers
from sjdsl.runtime.neighbourhood import entries_at, looked_up, over_neighbours

DIAMOND = tuple((a, b) for a in range(-2, 3) for b in range(-2, 3) if abs(a) + abs(b) <= 2)
MAPS = {"rectangle": ("....", "....", "...."), "holes": (".#..", "..#.", "#..."), "row": (".....",)}


def table_of(rows: tuple[str, ...]) -> np.ndarray:
    cells = cells_of(rows, 3, ".")
    return neighbours(cells, site_numbers(rows, 3, cells), shape_offsets(rows, 3, DIAMOND))


@pytest.mark.parametrize("rows", MAPS.values(), ids=MAPS)
@pytest.mark.parametrize("some", [False, True])
@pytest.mark.parametrize(("fold", "python"), [("sum", sum), ("max", max), ("min", min)])
def test_folds_are_those_of_a_loop(
    rows: tuple[str, ...], some: bool, fold: str, python: object
) -> None:
    table = table_of(rows)
    size = len(table)
    rng = np.random.default_rng(size)
    first, second = (
        rng.integers(0, 50, size).astype(np.int32),
        rng.integers(0, 9, size).astype(np.uint8),
    )
    around = rng.integers(0, size, size).astype(np.int32)

    def body(number: jax.Array, one: jax.Array, other: jax.Array) -> jax.Array:
        return jnp.where((number < size) & (other > 2), one + 100 * number, 7)

    given = {"around": jnp.asarray(around)} if some else {}
    found = over_neighbours(
        fold, jnp.asarray(table), body, jnp.asarray(first), jnp.asarray(second), **given
    )  # type: ignore[arg-type]
    wanted = [
        python(first[n] + 100 * n if n < size and second[n] > 2 else 7 for n in row)  # type: ignore[operator]
        for row in (table[around] if some else table)
    ]
    assert found.tolist() == wanted


def test_truths_are_counted() -> None:
    table = table_of(MAPS["holes"])
    size = len(table)
    mine = jnp.asarray(np.arange(size) % 3 == 0)
    found = over_neighbours(
        "sum", jnp.asarray(table), lambda number, field: (number < size) & field, mine
    )
    assert found.dtype == jnp.int32
    assert found.tolist() == [sum(n < size and n % 3 == 0 for n in row) for row in table.tolist()]


def test_lookups() -> None:
    values = jnp.asarray([[3, 4], [5, 6], [7, 8]])
    assert looked_up(values, jnp.asarray([[2, 0], [1, 1]])).tolist() == [
        [[7, 8], [3, 4]],
        [[5, 6], [5, 6]],
    ]
    assert entries_at(values, jnp.asarray([1, 0, 1])).tolist() == [4, 5, 8]

"""Which rows of a dense layer's kernel the tokens of a window select: planes of words and bits as row numbers in tables."""

import math
from collections.abc import Sequence
from itertools import accumulate

import jax.numpy as jnp
from jax import Array

from sjdsl.runtime.planes import TokenPlane

ROW_WORK = 4  # cost of making a row of a table and summing its gradient, in lookups of a row; measured (docs/performance.md)
LIMITS = tuple(2**power for power in range(9))  # the limits to try for the rows of a cell's table
INTEGERS = (
    (2**8, jnp.uint8),
    (2**16, jnp.uint16),
    (2**31, jnp.int32),
)  # how many rows each type can number

Planes = tuple[TokenPlane, ...]
Group = tuple[int, ...]  # planes that are looked up together, by their positions among all


def groups_of(planes: Planes, windows: int) -> tuple[Group, ...]:
    """Returns the planes of words and bits in the groups that take the least work, for a number of windows, to make tables and look rows up.

    A table for several planes has a row for each combination of their values, and saves lookups in every window.
    """
    found = [_groups_within(limit, planes) for limit in LIMITS]
    return min(
        found,
        key=lambda groups: sum(ROW_WORK * rows_of(group, planes) + windows for group in groups),
    )


def _groups_within(limit: int, planes: Planes) -> tuple[Group, ...]:
    """Returns the planes in groups, each in the first whose table stays within the limit; a group of one plane may exceed it."""
    groups: list[Group] = []
    for place, plane in enumerate(planes):
        if plane.encoding == "number":
            continue
        at = next(
            (at for at, group in enumerate(groups) if rows_of((*group, place), planes) <= limit),
            None,
        )
        if at is None:
            groups.append((place,))
        else:
            groups[at] = (*groups[at], place)
    return tuple(groups)


def rows_of(group: Group, planes: Planes) -> int:
    """Returns the number of combinations of values of the planes of a group."""
    return math.prod(_values(planes[place]) for place in group)


def row_numbers(tokens: Array, group: Group, planes: Planes) -> Array:
    """Returns which row of its cell's tables each window selects, `[cells, G * M]`, for tokens `[G, M, P, cells]` uint8.

    The tables of G networks follow each other. The result has the smallest integer type that holds it.
    """
    number, windows, _, cells = tokens.shape
    rows = rows_of(group, planes)
    numbers = jnp.broadcast_to(
        jnp.arange(number, dtype=jnp.int32)[:, None, None], (number, windows, cells)
    )
    for place in group:
        numbers = numbers * _values(planes[place]) + tokens[:, :, place].astype(jnp.int32)
    fitting = next(kind for most, kind in INTEGERS if number * rows <= most)
    return numbers.astype(fitting).reshape(number * windows, cells).T


def make_tables(rows: Sequence[Array], group: Group, planes: Planes) -> Array:
    """Returns the sums of rows of G kernels for each combination of values of the planes of a group, `[cells, G * rows, K]`.

    Args:
      rows: of each plane, the rows of its channels, `[L, cells, G, K]`.
    """
    _, cells, number, width = rows[0].shape
    tables = jnp.zeros((cells, number, 1, width), rows[0].dtype)
    for place in group:
        tables = (tables[:, :, :, None] + _table(rows[place], planes[place])[:, :, None]).reshape(
            cells, number, -1, width
        )
    return tables.reshape(cells, -1, width)


def rows_by_plane(rows: Array, planes: Planes) -> list[Array]:
    """Returns the rows of all channels, `[C, ...]`, of each plane: `[L, ...]`."""
    ends = accumulate(len(plane.channels) for plane in planes)
    return jnp.split(rows, list(ends)[:-1])


def _values(plane: TokenPlane) -> int:
    return len(plane.labels) if plane.encoding == "word" else 2 ** len(plane.labels)


def _table(rows: Array, plane: TokenPlane) -> Array:
    """Returns the sums of rows for each value of one plane, `[cells, G, values, K]`, of the rows `[L, cells, G, K]` of its channels."""
    if plane.encoding == "word":
        return jnp.moveaxis(rows, 0, 2)
    sums = jnp.zeros_like(rows[0])[:, :, None]
    for row in rows:  # bit k has the value 2^k
        sums = jnp.concatenate([sums, sums + row[:, :, None]], axis=2)
    return sums

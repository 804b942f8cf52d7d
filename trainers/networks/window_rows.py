"""Which rows of a dense layer's kernel the tokens of a window select.

Planes of words and bits become row numbers in tables.
"""

import math
from collections.abc import Sequence
from itertools import accumulate

import jax.numpy as jnp
from jax import Array

from sjdsl.runtime.planes import TokenPlane

# cost of making a row of a table and summing its gradient, in lookups of a row; measured
# (docs/performance.md)
ROW_WORK = 4
LIMITS = tuple(2**power for power in range(9))  # the limits to try for the rows of a cell's table
# types of integers, with the largest that each holds
INTEGERS = ((2**8 - 1, jnp.uint8), (2**16 - 1, jnp.uint16), (2**31 - 1, jnp.int32))

Planes = tuple[TokenPlane, ...]
Group = tuple[int, ...]  # planes that are looked up together, by their positions among all


def groups_of(planes: Planes, windows: int) -> tuple[Group, ...]:
    """Returns the planes of words and bits in the groups that take the least work.

    A table for several planes has a row for each combination of their values, and saves lookups in
    every window.
    """

    def work(groups: tuple[Group, ...]) -> int:
        return sum(ROW_WORK * rows_of(group, planes) + windows for group in groups)

    return min((_groups_within(limit, planes) for limit in LIMITS), key=work)


def _groups_within(limit: int, planes: Planes) -> tuple[Group, ...]:
    """Returns the planes in groups, each in the first whose table stays within the limit.

    A group of one plane may exceed it.
    """
    groups: list[Group] = []
    for place, plane in enumerate(planes):
        if plane.encoding == "number":
            continue
        for index, group in enumerate(groups):
            if rows_of((*group, place), planes) <= limit:
                groups[index] = (*group, place)
                break
        else:
            groups.append((place,))
    return tuple(groups)


def rows_of(group: Group, planes: Planes) -> int:
    """Returns the number of combinations of values of the planes of a group."""
    return math.prod(_values(planes[place]) for place in group)


def row_numbers(tokens: Array, group: Group, planes: Planes) -> Array:
    """Returns which row of its cell's tables each window selects, `[cells, G * M]`.

    The tables of G networks follow each other. The result has the smallest integer type that holds
    it.

    Args:
      tokens: `[G, M, P, cells]` uint8.
    """
    number, windows, _, cells = tokens.shape
    last = number * rows_of(group, planes) - 1
    networks = jnp.arange(number, dtype=jnp.int32)[:, None, None]
    numbers = jnp.broadcast_to(networks, (number, windows, cells))
    for place in group:
        numbers = numbers * _values(planes[place]) + tokens[:, :, place].astype(jnp.int32)
    dtype = next(dtype for largest, dtype in INTEGERS if last <= largest)
    return numbers.astype(dtype).reshape(number * windows, cells).T


def make_tables(rows: Sequence[Array], group: Group, planes: Planes) -> Array:
    """Returns the sums of rows of G kernels, `[cells, G * rows, K]`.

    There is one for each combination of values of the planes of a group.

    Args:
      rows: of each plane, the rows of its channels, `[L, cells, G, K]`.
    """
    _, cells, number, width = rows[0].shape
    tables = jnp.zeros((cells, number, 1, width), rows[0].dtype)
    for place in group:
        table = _table(rows[place], planes[place])
        tables = tables[:, :, :, None] + table[:, :, None]
        tables = tables.reshape(cells, number, -1, width)
    return tables.reshape(cells, -1, width)


def rows_by_plane(rows: Array, planes: Planes) -> list[Array]:
    """Returns the rows of all channels, `[C, ...]`, of each plane: `[L, ...]`."""
    ends = accumulate(len(plane.channels) for plane in planes)
    return jnp.split(rows, list(ends)[:-1])


def _values(plane: TokenPlane) -> int:
    return len(plane.labels) if plane.encoding == "word" else 2 ** len(plane.labels)


def _table(rows: Array, plane: TokenPlane) -> Array:
    """Returns the sums of rows for each value of one plane, `[cells, G, values, K]`.

    Args:
      rows: of its channels, `[L, cells, G, K]`.
    """
    if plane.encoding == "word":
        return jnp.moveaxis(rows, 0, 2)
    sums = jnp.zeros_like(rows[0])[:, :, None]
    for row in rows:  # bit k has the value 2^k
        sums = jnp.concatenate([sums, sums + row[:, :, None]], axis=2)
    return sums

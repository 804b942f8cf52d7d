"""Tables in which the content of a window's cell is looked up, for a dense layer on its channels.

A table has a row for each combination of values of some planes of words and bits: the sum of the
kernel's rows that these values select.
"""

import math
from collections.abc import Sequence
from itertools import accumulate

import jax.numpy as jnp
from jax import Array

from sjdsl.runtime.planes import TokenPlane

# cost of making a row of a table and summing its gradient, in lookups of a row; measured
# (docs/research/performance.md)
ROW_WORK = 4
# the limits to try for the rows of a table; at most as many as a byte numbers
LIMITS = tuple(2**power for power in range(9))

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
    """Returns the row of its cell's table that each window selects, `[cells, M]` uint8.

    Args:
      tokens: `[M, P, cells]` uint8.
    """
    numbers = jnp.zeros(tokens[:, 0].shape, jnp.int32)
    for place in group:
        numbers = numbers * _values(planes[place]) + tokens[:, place].astype(jnp.int32)
    return numbers.astype(jnp.uint8).T


def make_table(rows: Sequence[Array], group: Group, planes: Planes) -> Array:
    """Returns the table of a group for one cell, `[rows, K]`.

    Args:
      rows: of each plane, the rows of its channels in that cell, `[L, K]`.
    """
    width = rows[0].shape[-1]
    table = jnp.zeros((1, width), rows[0].dtype)
    for place in group:
        sums = _sums(rows[place], planes[place])
        table = (table[:, None] + sums).reshape(-1, width)
    return table


def rows_by_plane(rows: Array, planes: Planes) -> list[Array]:
    """Returns the rows of all channels, `[C, ...]`, of each plane: `[L, ...]`."""
    ends = accumulate(len(plane.channels) for plane in planes)
    return jnp.split(rows, list(ends)[:-1])


def _values(plane: TokenPlane) -> int:
    return len(plane.labels) if plane.encoding == "word" else 2 ** len(plane.labels)


def _sums(rows: Array, plane: TokenPlane) -> Array:
    """Returns the sums of the rows `[L, K]` of a plane's channels for each value, `[values, K]`."""
    if plane.encoding == "word":
        return rows
    sums = jnp.zeros_like(rows[:1])
    for row in rows:  # bit k has the value 2^k
        sums = jnp.concatenate([sums, sums + row])
    return sums

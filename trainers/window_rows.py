"""Which rows of a dense layer's kernel the tokens of a window choose: planes of words and bits as numbers of rows in tables."""

import math

import jax.numpy as jnp
from jax import Array

from sjdsl.runtime.planes import TokenPlane

MOST_ROWS = 256  # of a cell's table: one lookup for several planes is worth making larger tables; an index is a byte

Planes = tuple[TokenPlane, ...]
Group = tuple[int, ...]  # planes that are looked up together, by their places among all


def groups_of(planes: Planes) -> tuple[Group, ...]:
    """Returns the planes of words and of bits in groups, each plane in the first group whose table stays small enough."""
    groups: list[Group] = []
    for place, plane in enumerate(planes):
        if plane.encoding == "number":
            continue
        fits = (at for at, group in enumerate(groups) if rows_of((*group, place), planes) <= MOST_ROWS)
        at = next(fits, None)
        if at is None:
            groups.append((place,))
        else:
            groups[at] = (*groups[at], place)
    return tuple(groups)


def rows_of(group: Group, planes: Planes) -> int:
    """Returns how many combinations of values the planes of a group have."""
    return math.prod(_values(planes[place]) for place in group)


def row_numbers(tokens: Array, group: Group, planes: Planes) -> Array:
    """Returns which row of its cell's table each window chooses, `[cells, M]` uint8, of tokens `[M, P, cells]` uint8."""
    numbers = jnp.zeros((tokens.shape[0], tokens.shape[-1]), jnp.int32)
    for place in group:
        numbers = numbers * _values(planes[place]) + tokens[:, place].astype(jnp.int32)
    return numbers.astype(jnp.uint8).T


def make_tables(kernel: Array, group: Group, planes: Planes) -> Array:
    """Returns the sums of kernel rows for each combination of values, `[cells, rows, K]`, of a kernel `[C, cells, K]`."""
    _, cells, width = kernel.shape
    tables = jnp.zeros((cells, 1, width), kernel.dtype)
    for place in group:
        values = _table(kernel[channels_of(place, planes)], planes[place])
        tables = (tables[:, :, None] + values[:, None]).reshape(cells, -1, width)
    return tables


def channels_of(place: int, planes: Planes) -> slice:
    """Returns which of all channels are those of a plane."""
    before = sum(len(plane.channels) for plane in planes[:place])
    return slice(before, before + len(planes[place].channels))


def _values(plane: TokenPlane) -> int:
    return len(plane.labels) if plane.encoding == "word" else 2 ** len(plane.labels)


def _table(rows: Array, plane: TokenPlane) -> Array:
    """Returns the sum of kernel rows for each value of one plane, `[cells, values, K]`, of the rows `[L, cells, K]` of its channels."""
    if plane.encoding == "word":
        return jnp.moveaxis(rows, 0, 1)
    sums = jnp.zeros_like(rows[0])[:, None]
    for row in rows:  # bit k has the value 2^k
        sums = jnp.concatenate([sums, sums + row[:, None]], axis=1)
    return sums

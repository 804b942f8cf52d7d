"""Writes a few entries of an array, in two forms.

A CPU writes them one after the other. XLA for GPUs would make a kernel of its own of such a
scatter, so there each entry compares its place with those that are written to.
"""

import math
import operator
from collections.abc import Callable
from functools import reduce
from typing import Any

import jax.numpy as jnp
import numpy as np
from jax import Array, lax

from sjdsl.runtime.forms import by_platform

Places = Array | tuple[Array | int, ...]
MOST_WRITERS = 32
MOST_COMPARISONS = 8192  # of an entry with a writer: more cost more than a scatter


def set_at(values: Array, places: Places, new: Any) -> Array:
    """Returns values with new ones at some places.

    Args:
      values: any shape and dtype.
      places: integers, numbers along the first axis, or a tuple of such arrays (or numbers) for as
        many axes, whose shapes fit together. What is written past the end is dropped. No two
        writers write different values to one place.
      new: one number for all writers, or an entry of `values` for each.
    """
    return _written(_set_in_turn, _set_by_comparing, values, places, new)


def add_at(values: Array, places: Places, amounts: Any) -> Array:
    """Returns values with amounts added at some places, of which several may be the same.

    Args:
      values, places: as of `set_at`.
      amounts: one number for all writers, or an entry of `values` for each.
    """
    return _written(_add_in_turn, _add_by_comparing, values, places, amounts)


def set_entry(values: Array, number: int, new: Any, axis: int = -1) -> Array:
    """Returns values with a new one at a number along an axis.

    Args:
      new: a number, or of the shape of `values` without the axis.
      axis: counted from the last, -1.
    """
    return jnp.where(_is_entry(values, number, axis), _with_axis(new, axis), values)


def add_to_entry(values: Array, number: int, amounts: Any, axis: int = -1) -> Array:
    """Returns values with amounts added at a number along an axis.

    Args:
      amounts: a number, or of the shape of `values` without the axis.
      axis: counted from the last, -1.
    """
    return jnp.where(_is_entry(values, number, axis), values + _with_axis(amounts, axis), values)


def _is_entry(values: Array, number: int, axis: int) -> Array:
    along = jnp.arange(values.shape[axis], dtype=jnp.int32) == number
    shape = [1] * values.ndim
    shape[axis] = -1
    return along.reshape(shape)


def _with_axis(new: Any, axis: int) -> Any:
    """Returns what is written with an axis of length 1; a number stays one."""
    if np.ndim(new) == 0:
        return new
    behind = [slice(None)] * (-1 - axis)  # the axes after it
    return new[(..., None, *behind)]


def _written(
    in_turn: Callable[..., Array],
    by_comparing: Callable[..., Array],
    values: Array,
    places: Places,
    new: Any,
) -> Array:
    """Returns what is written by one of two forms: see `set_at`."""
    given = places if isinstance(places, tuple) else (places,)
    numbers = tuple(map(jnp.asarray, given))
    writers = math.prod(np.broadcast_shapes(*(number.shape for number in numbers)))
    if writers == 0:
        return values
    if writers > MOST_WRITERS or writers * values.size > MOST_COMPARISONS:
        return in_turn(values, numbers, new)
    return by_platform(in_turn, by_comparing, values, numbers, new)


def _set_in_turn(values: Array, numbers: tuple[Array, ...], new: Any) -> Array:
    """The form for CPUs."""
    return values.at[numbers].set(new, mode="drop")


def _add_in_turn(values: Array, numbers: tuple[Array, ...], amounts: Any) -> Array:
    """The form for CPUs."""
    return values.at[numbers].add(amounts, mode="drop")


def _set_by_comparing(values: Array, numbers: tuple[Array, ...], new: Any) -> Array:
    """The form for GPUs."""
    written = _places_of_writers(values, numbers)
    if np.ndim(new) == 0:
        somewhere = reduce(operator.or_, written)
        return jnp.where(somewhere, jnp.asarray(new).astype(values.dtype), values)
    for place, entry in zip(written, _entries(values, numbers, new), strict=True):
        values = jnp.where(place, entry, values)
    return values


def _add_by_comparing(values: Array, numbers: tuple[Array, ...], amounts: Any) -> Array:
    """The form for GPUs."""
    written = _places_of_writers(values, numbers)
    for place, amount in zip(written, _entries(values, numbers, amounts), strict=True):
        values = values + jnp.where(place, amount, jnp.zeros((), values.dtype))
    return values


def _places_of_writers(values: Array, numbers: tuple[Array, ...]) -> list[Array]:
    """Returns where each writer writes: bool, of the shape of the values."""
    shape = np.broadcast_shapes(*(number.shape for number in numbers))
    by_axis = []  # of each axis, of each writer: where its number along that axis is
    for axis, number in enumerate(numbers):
        along = lax.broadcasted_iota(jnp.int32, values.shape, axis)
        number = number.astype(jnp.int32)
        from_start = jnp.where(number < 0, number + values.shape[axis], number)
        of_writers = jnp.broadcast_to(from_start, shape).reshape(-1)
        by_axis.append(
            [along == lax.squeeze(one, (0,)) for one in jnp.split(of_writers, len(of_writers))]
        )
    return [reduce(operator.and_, of_writer) for of_writer in zip(*by_axis, strict=True)]


def _entries(values: Array, numbers: tuple[Array, ...], new: Any) -> list[Array]:
    """Returns what each writer writes, with an axis of length 1 for each of the numbers."""
    shape = np.broadcast_shapes(*(number.shape for number in numbers))
    entry = values.shape[len(numbers) :]
    spread = jnp.broadcast_to(jnp.asarray(new).astype(values.dtype), (*shape, *entry))
    flat = spread.reshape(-1, *entry)
    parts = jnp.split(flat, len(flat))
    return [part.reshape((1,) * len(numbers) + entry) for part in parts]

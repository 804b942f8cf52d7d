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
# A GPU compares each entry with each writer; if there are more of them, a scatter is faster.
MOST_WRITERS = 32
MOST_COMPARISONS = 8192


def set_at(values: Array, places: Places, new: Any) -> Array:
    """Returns `values.at[places].set(new)`: each entry of `places` is a writer of one entry.

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
    """Returns where the number along an axis is so: bool, of length 1 along the other axes."""
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
    places = places if isinstance(places, tuple) else (places,)
    numbers = tuple(map(jnp.asarray, places))
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
    is_written = _places_of_writers(values, numbers)
    if np.ndim(new) == 0:
        by_any = reduce(operator.or_, is_written)
        return jnp.where(by_any, jnp.asarray(new).astype(values.dtype), values)
    for by_one, entry in zip(is_written, _entries(values, numbers, new), strict=True):
        values = jnp.where(by_one, entry, values)
    return values


def _add_by_comparing(values: Array, numbers: tuple[Array, ...], amounts: Any) -> Array:
    """The form for GPUs."""
    is_written = _places_of_writers(values, numbers)
    for by_one, amount in zip(is_written, _entries(values, numbers, amounts), strict=True):
        values = values + jnp.where(by_one, amount, jnp.zeros((), values.dtype))
    return values


def _places_of_writers(values: Array, numbers: tuple[Array, ...]) -> list[Array]:
    """Returns for each writer where it writes: bool, of the shape of the values."""
    shape = np.broadcast_shapes(*(number.shape for number in numbers))
    matches_by_axis = []  # for each axis and writer: where the number along it is the writer's
    for axis, number in enumerate(numbers):
        along = lax.broadcasted_iota(jnp.int32, values.shape, axis)
        number = number.astype(jnp.int32)
        from_start = jnp.where(number < 0, number + values.shape[axis], number)
        of_writers = jnp.broadcast_to(from_start, shape).reshape(-1)
        of_each = jnp.split(of_writers, len(of_writers))
        matches_by_axis.append([along == lax.squeeze(number, (0,)) for number in of_each])
    return [reduce(operator.and_, matches) for matches in zip(*matches_by_axis, strict=True)]


def _entries(values: Array, numbers: tuple[Array, ...], new: Any) -> list[Array]:
    """Returns what each writer writes, with an axis of length 1 for each of the numbers."""
    shape = np.broadcast_shapes(*(number.shape for number in numbers))
    entry_shape = values.shape[len(numbers) :]
    converted = jnp.asarray(new).astype(values.dtype)
    of_writers = jnp.broadcast_to(converted, (*shape, *entry_shape)).reshape(-1, *entry_shape)
    of_each = jnp.split(of_writers, len(of_writers))
    with_axes = (1,) * len(numbers) + entry_shape
    return [entry.reshape(with_axes) for entry in of_each]

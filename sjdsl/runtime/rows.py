"""Operations on the last axis of arrays, a row for each index, and entries by their numbers."""

from typing import Any, TypeVar

import jax.numpy as jnp
import numpy as np
from jax import Array

from sjdsl.runtime.reductions import argmax_of, sum_of

A = TypeVar("A", Array, np.ndarray)


def on_last_axis(entries: A, num_axes: int) -> A:
    """Returns entries `[K]` on the last of so many axes: `[1, ..., 1, K]`."""
    return entries.reshape((1,) * (num_axes - 1) + (-1,))


def numbers_on_last_axis(size: int, num_axes: int, dtype: Any = jnp.int32) -> Array:
    """Returns the numbers from 0 on the last of so many axes: `[1, ..., 1, size]`."""
    return on_last_axis(jnp.arange(size, dtype=dtype), num_axes)


def entries_in_bounds(values: Array, numbers: Array) -> Array:
    """Returns entries of the first axis, undefined for numbers past the end.

    No number is negative, so none is tested whether it counts from the end.
    """
    return values.at[numbers].get(mode="promise_in_bounds", wrap_negative_indices=False)


def one_hot(number: Array | int, size: int) -> Array:
    """Returns rows that hold at one number each: `[...]` integers -> `[..., size]` bool."""
    numbers = jnp.asarray(number)
    return numbers[..., None] == numbers_on_last_axis(size, numbers.ndim + 1, numbers.dtype)


def entry(row: Array, key: Array) -> Array:
    """Returns `row[..., key]`: one entry of each row. Shapes `[..., K]` and `[...]`."""
    return sum_of(jnp.where(one_hot(key, row.shape[-1]), row, 0), axis=-1)


def lowest(row: Array) -> Array:
    """Returns the index of the first positive entry, 0 without one: `[..., K]` -> `[...]` uint8."""
    return argmax_of(row > 0, axis=-1).astype(jnp.uint8)


def highest(row: Array) -> Array:
    """Returns the index of the last positive entry: `[..., K]` -> `[...]` uint8.

    Without one, it is the last index.
    """
    from_last = argmax_of(row[..., ::-1] > 0, axis=-1)
    return (row.shape[-1] - 1 - from_last).astype(jnp.uint8)


def mix(row: Array) -> Array:
    """Returns the shares of a row's entries, float32; of an empty row zeros.

    The compiler ensures that these aren't used.
    """
    total = sum_of(row, axis=-1)[..., None].astype(jnp.float32)
    return row.astype(jnp.float32) / jnp.where(total > 0, total, 1)


def shifted(row: Array, by: int, filler: Array) -> Array:
    """Returns each row with its entries moved by some places, and the filler in the places left.

    Args:
      row: `[..., K]`; by: places, negative to the front; filler: `[...]`.

    Returns:
      `[..., K]`.
    """
    size = row.shape[-1]
    source = jnp.arange(size, dtype=jnp.int32) - by
    exists = (source >= 0) & (source < size)
    moved = row[..., jnp.clip(source, 0, size - 1)]
    return jnp.where(on_last_axis(exists, row.ndim), moved, filler[..., None])


def ramp(value: Array, zero_at: Array, one_at: Array) -> Array:
    """Returns (value - zero_at) / (one_at - zero_at), clipped to 0 .. 1."""
    return jnp.clip((value - zero_at) / (one_at - zero_at), 0.0, 1.0)

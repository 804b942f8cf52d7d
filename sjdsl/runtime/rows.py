"""Operations on the last axis of arrays, a row for each index: entries, shares, shifts, ramps."""

import jax.numpy as jnp
from jax import Array

from sjdsl.runtime.reductions import argmax_of, sum_of


def one_hot(number: Array | int, size: int) -> Array:
    """Returns rows that hold at one number each: `[...]` integers -> `[..., size]` bool."""
    numbers = jnp.asarray(number)
    along = jnp.arange(size, dtype=numbers.dtype).reshape((1,) * numbers.ndim + (-1,))
    return numbers[..., None] == along


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
    return (row.shape[-1] - 1 - argmax_of(row[..., ::-1] > 0, axis=-1)).astype(jnp.uint8)


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
    source = jnp.arange(row.shape[-1], dtype=jnp.int32) - by
    known = (source >= 0) & (source < row.shape[-1])
    moved = row[..., jnp.clip(source, 0, row.shape[-1] - 1)]
    return jnp.where(known.reshape((1,) * (row.ndim - 1) + (-1,)), moved, filler[..., None])


def ramp(value: Array, zero_at: Array, one_at: Array) -> Array:
    """Returns (value - zero_at) / (one_at - zero_at), clipped to 0 .. 1."""
    return jnp.clip((value - zero_at) / (one_at - zero_at), 0.0, 1.0)

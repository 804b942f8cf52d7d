"""Operations on rows of numbers: an entry, the smallest and largest, shares, a row shifted, ramps."""

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
    """Returns the first word with a positive entry, 0 if there is none: `[..., K]` -> `[...]` uint8."""
    return argmax_of(row > 0, axis=-1).astype(jnp.uint8)


def highest(row: Array) -> Array:
    """Returns the last word with a positive entry, the last of all if there is none: `[..., K]` -> `[...]` uint8."""
    return (row.shape[-1] - 1 - argmax_of(row[..., ::-1] > 0, axis=-1)).astype(jnp.uint8)


def mix(row: Array) -> Array:
    """Returns the shares of a row's entries, float32; of an empty row zeros (never used: guards are checked)."""
    total = sum_of(row, axis=-1)[..., None].astype(jnp.float32)
    return row.astype(jnp.float32) / jnp.where(total > 0, total, 1)


def shifted(row: Array, by: int, filler: Array) -> Array:
    """Returns each row with its entries `by` places further on, the filler where none comes from: `[..., K]` and `[...]` -> `[..., K]`."""
    source = jnp.arange(row.shape[-1], dtype=jnp.int32) - by
    known = (source >= 0) & (source < row.shape[-1])
    moved = row[..., jnp.clip(source, 0, row.shape[-1] - 1)]
    return jnp.where(known.reshape((1,) * (row.ndim - 1) + (-1,)), moved, filler[..., None])


def ramp(value: Array, zero_at: Array, one_at: Array) -> Array:
    """Returns (value - zero_at) / (one_at - zero_at), clipped to 0 .. 1."""
    return jnp.clip((value - zero_at) / (one_at - zero_at), 0.0, 1.0)

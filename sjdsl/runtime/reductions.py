"""Reductions along axes, in two forms.

XLA for GPUs makes a kernel of its own for a reduction of 2, 4, 8 or 16 entries, the sizes that
divide a warp, but puts one of 5 or 9 where its result is read. So in the form for GPUs such a
reduction gets one more entry, which changes nothing.
"""

import math
from collections.abc import Callable
from functools import partial
from typing import Any

import jax.numpy as jnp
import numpy as np
from jax import Array, lax

from sjdsl.runtime.forms import by_platform

Axes = int | tuple[int, ...] | None  # None: all
WARP = 32  # lanes of a GPU that work together


def any_of(values: Array, axis: Axes = None) -> Array:
    """Returns whether some entry along the axes holds: bool."""
    return _reduced(jnp.any, values, axis, False)


def all_of(values: Array, axis: Axes = None) -> Array:
    """Returns whether all entries along the axes hold: bool."""
    return _reduced(jnp.all, values, axis, True)


def count_of(values: Array, axis: Axes = None) -> Array:
    """Returns how many entries along the axes hold: int32."""
    return sum_of(values, axis, jnp.int32)


def sum_of(values: Array, axis: Axes = None, dtype: Any = None) -> Array:
    """Returns the sum along the axes, in a dtype: that of the values if none is given."""
    add = partial(jnp.sum, dtype=values.dtype if dtype is None else dtype)
    return _reduced(add, values, axis, 0)


def max_of(values: Array, axis: Axes = None) -> Array:
    """Returns the greatest entry along the axes."""
    return _reduced(jnp.max, values, axis, _least(values.dtype))


def min_of(values: Array, axis: Axes = None) -> Array:
    """Returns the least entry along the axes."""
    return _reduced(jnp.min, values, axis, _greatest(values.dtype))


def argmax_of(values: Array, axis: int) -> Array:
    """Returns the number of the first of the greatest entries along an axis: int32."""
    return _reduced(jnp.argmax, values, axis, _least(values.dtype)).astype(jnp.int32)


def _reduced(reduction: Callable[..., Array], values: Array, axis: Axes, filler: Any) -> Array:
    """Returns a reduction. `filler`: an entry that changes nothing."""

    def with_one_more(values: Array) -> Array:
        return reduction(lengthened(values, axis, filler), axis=axis)

    return by_platform(partial(reduction, axis=axis), with_one_more, values)


def lengthened(values: Array, axis: Axes, filler: Any) -> Array:
    """Returns values with one more entry, for GPUs, if a reduction along the axes were a kernel."""
    if axis is None:
        axes = list(range(values.ndim))
    elif isinstance(axis, int):
        axes = [axis % values.ndim]
    else:
        axes = [one % values.ndim for one in axis]
    size = math.prod(values.shape[one] for one in axes)
    if size < 2 or size >= WARP or WARP % size:
        return values
    edges = [(0, 0, 0)] * values.ndim  # before, behind and between entries
    edges[axes[-1]] = (0, 1, 0)
    return lax.pad(values, jnp.asarray(filler, values.dtype), edges)


def _least(dtype: np.dtype[Any]) -> Any:
    """Returns what no value of a dtype is less than."""
    if dtype.kind == "b":
        return False
    return -np.inf if dtype.kind == "f" else np.iinfo(dtype).min


def _greatest(dtype: np.dtype[Any]) -> Any:
    """Returns what no value of a dtype is greater than."""
    if dtype.kind == "b":
        return True
    return np.inf if dtype.kind == "f" else np.iinfo(dtype).max

"""The first dense layer of a network that reads windows of tokens flat: a sum of looked-up rows on a CPU, a product elsewhere.

Its input has a channel for each value that a token can have, and almost all of it is zero. On a CPU a loop over the cells of a
window looks up the rows of the kernel that belong to what is in the cell, of all windows at once, and adds them. That is several
times as fast as the product (docs/performance.md). GPUs are made for products.
"""

import math
from functools import partial
from typing import Any

import flax.linen as nn
import jax
import jax.numpy as jnp
from jax import Array

from sjdsl.runtime.tokens import to_channels

from .initialisation import orthogonal
from .window_rows import Planes, channels_of, groups_of, make_tables, row_numbers, rows_of


class WindowLayer(nn.Module):
    """A dense layer on the channels of windows, as `nn.Dense` would be on them, with its parameters and their names."""

    width: int
    planes: Planes
    gain: float
    dtype: Any

    @nn.compact
    def __call__(self, tokens: Array) -> Array:
        """Returns `[..., width]` of windows `[..., P, V, V]` uint8, of values that their planes have."""
        lead, window = tokens.shape[:-3], tokens.shape[-3:]
        inputs = sum(len(plane.channels) for plane in self.planes) * math.prod(window[1:])
        kernel = self.param("kernel", orthogonal(self.gain), (inputs, self.width))
        bias = self.param("bias", nn.initializers.zeros, (self.width,))
        result: Array = weigh(kernel.astype(self.dtype), tokens.reshape(-1, *window), self.planes) + bias.astype(self.dtype)
        return result.reshape(*lead, self.width)


@partial(jax.custom_vjp, nondiff_argnums=(2,))
def weigh(kernel: Array, tokens: Array, planes: Planes) -> Array:
    """Returns the channels of windows `[M, P, V, V]` uint8 times a kernel `[C * V * V, K]`: `[M, K]` of the kernel's dtype."""
    result: Array = jax.lax.platform_dependent(
        kernel, tokens, cpu=partial(look_up, planes=planes), default=partial(_multiply, planes=planes)
    )
    return result


def _forward(kernel: Array, tokens: Array, planes: Planes) -> tuple[Array, tuple[Array, Array]]:
    return weigh(kernel, tokens, planes), (kernel, tokens)


def _backward(planes: Planes, inputs: tuple[Array, Array], gradient: Array) -> tuple[Array, None]:
    kernel, tokens = inputs
    of_kernel: Array = jax.lax.platform_dependent(
        tokens, gradient, cpu=partial(look_up_gradient, planes=planes), default=partial(_multiply_gradient, planes=planes)
    )
    return of_kernel.astype(kernel.dtype), None


weigh.defvjp(_forward, _backward)


def _multiply(kernel: Array, tokens: Array, planes: Planes) -> Array:
    return _channels(tokens, planes, kernel.dtype) @ kernel


def _multiply_gradient(tokens: Array, gradient: Array, planes: Planes) -> Array:
    """Returns the kernel's gradient `[C * V * V, K]` float32; its transpose is faster to make."""
    return jnp.matmul(gradient.T, _channels(tokens, planes, gradient.dtype), preferred_element_type=jnp.float32).T


def _channels(tokens: Array, planes: Planes, dtype: Any) -> Array:
    """Returns the channels of windows, flat: `[M, C * V * V]`."""
    channels = to_channels(tokens, planes, dtype, scale_numbers=True)
    return channels.reshape(tokens.shape[0], math.prod(channels.shape[1:]))  # not -1: there may be no windows


def look_up(kernel: Array, tokens: Array, planes: Planes) -> Array:
    """Returns what `weigh` does. Sums are made in float32."""
    cells = _by_cell(tokens)
    rows = kernel.reshape(-1, cells.shape[-1], kernel.shape[-1]).astype(jnp.float32)
    result = jnp.zeros((tokens.shape[0], kernel.shape[-1]), jnp.float32)
    for group in groups_of(planes):
        result = _add_rows(result, make_tables(rows, group, planes), row_numbers(cells, group, planes))
    for place in _number_planes(planes):
        (own,) = rows[channels_of(place, planes)]
        result = result + _multiply(own, tokens[:, place : place + 1], (planes[place],))
    return result.astype(kernel.dtype)


def look_up_gradient(tokens: Array, gradient: Array, planes: Planes) -> Array:
    """Returns the gradient of the kernel `[C * V * V, K]` float32, of that of the result `[M, K]`."""
    cells, gradient, groups = _by_cell(tokens), gradient.astype(jnp.float32), groups_of(planes)
    shape = (sum(len(plane.channels) for plane in planes), cells.shape[-1], gradient.shape[-1])

    def tables(rows: Array) -> list[Array]:
        return [make_tables(rows, group, planes) for group in groups]

    of_tables = [_add_gradients(row_numbers(cells, group, planes), gradient, rows_of(group, planes)) for group in groups]
    of_rows: Array
    (of_rows,) = jax.linear_transpose(tables, jax.ShapeDtypeStruct(shape, jnp.float32))(of_tables)
    for place in _number_planes(planes):
        own = _multiply_gradient(tokens[:, place : place + 1], gradient, (planes[place],))
        of_rows = of_rows.at[channels_of(place, planes)].set(own[None])
    return of_rows.reshape(-1, shape[-1])


def _by_cell(tokens: Array) -> Array:
    """Returns windows `[M, P, V, V]` as `[M, P, cells]`."""
    return tokens.reshape(*tokens.shape[:2], math.prod(tokens.shape[2:]))


def _number_planes(planes: Planes) -> list[int]:
    """Returns the places of the planes that are numbers: each is one channel, and no table could have a row for every value."""
    return [place for place, plane in enumerate(planes) if plane.encoding == "number"]


def _add_rows(result: Array, tables: Array, numbers: Array) -> Array:
    """Adds to a result `[M, K]` the rows `[cells, M]` of tables `[cells, rows, K]`."""

    def add_cell(result: Array, cell: tuple[Array, Array]) -> tuple[Array, None]:
        table, chosen = cell
        return result + table.at[chosen].get(mode="clip"), None

    result, _ = jax.lax.scan(add_cell, result, (tables, numbers))
    return result


def _add_gradients(numbers: Array, gradient: Array, rows: int) -> Array:
    """Returns the sums `[cells, rows, K]` of the gradients `[M, K]` of the windows that chose a row `[cells, M]`."""

    def add_cell(_: None, chosen: Array) -> tuple[None, Array]:
        return None, jnp.zeros((rows, gradient.shape[-1]), gradient.dtype).at[chosen].add(gradient, mode="drop")

    _, result = jax.lax.scan(add_cell, None, numbers)
    return result

"""The first dense layer of a network that reads windows of tokens flat.

It is a sum of looked-up rows on a CPU, a product elsewhere. Its input has a channel for each value
that a token can have, and is almost all zeros. On a CPU, a loop over the cells of a window looks up
the rows of the kernel for the cell's content, in all windows at once, and adds them. That is
several times as fast as the product (docs/research/performance.md). GPUs are better at products.
"""

import math
from collections.abc import Callable
from functools import partial
from typing import Any

import flax.linen as nn
import jax
import jax.numpy as jnp
from jax import Array
from jax.custom_batching import sequential_vmap

from sjdsl.runtime.tokens import to_channels

from .initialisation import orthogonal
from .kernel_by_kernel import kernel_by_kernel
from .window_tables import Planes, groups_of, make_table, row_numbers, rows_by_plane, rows_of

# Numbers in a row of a matrix, or a multiple of them: for a GPU, XLA copies other rows to longer
# ones.
ALIGNED = 8
# cells whose rows are added in one pass over the windows; measured (docs/research/performance.md)
CELLS = 4

Linear = Callable[[Array, Array], Array]  # of an array and of windows; linear in the array


class WindowLayer(nn.Module):
    """A dense layer on the channels of windows.

    It has the parameters, and their names, of `nn.Dense` on those channels.
    """

    width: int
    planes: Planes
    gain: float
    dtype: Any

    @nn.compact
    def __call__(self, tokens: Array) -> Array:
        """Returns `[..., width]` of windows `[..., P, V, V]` uint8, with values of their planes."""
        shape = (_num_inputs(tokens, self.planes), self.width)
        kernel = self.param("kernel", orthogonal(self.gain), shape)
        bias = self.param("bias", nn.initializers.zeros, (self.width,), jnp.float32)
        windows = tokens.reshape(-1, *tokens.shape[-3:])
        weighed = _weigh_once(kernel, windows, self.planes, self.dtype)
        return (weighed + bias.astype(self.dtype)).reshape(*tokens.shape[:-3], self.width)


def _num_inputs(tokens: Array, planes: Planes) -> int:
    """Returns the channels of a window of tokens `[..., V, V]`, over all its cells."""
    return sum(len(plane.channels) for plane in planes) * math.prod(tokens.shape[-2:])


def _weigh_once(kernel: Array, tokens: Array, planes: Planes, dtype: Any) -> Array:
    """Computes `weigh` with uniform planes as one cell, whose rows are the sums over all cells."""
    uniform = [place for place, plane in enumerate(planes) if plane.uniform]
    if not uniform:
        return weigh(kernel.astype(dtype), tokens, planes)
    local = [place for place, plane in enumerate(planes) if not plane.uniform]
    width = kernel.shape[-1]
    num_cells = math.prod(tokens.shape[2:])
    rows = rows_by_plane(kernel.reshape(-1, num_cells, width), planes)
    local_rows = jnp.concatenate([rows[place] for place in local])
    by_cell = local_rows.reshape(-1, width).astype(dtype)
    summed = jnp.concatenate([rows[place].sum(axis=1) for place in uniform]).astype(dtype)
    local_planes = tuple(planes[place] for place in local)
    uniform_planes = tuple(planes[place] for place in uniform)
    one_cell = _taken(tokens[:, :, :1, :1], uniform)
    once = to_channels(one_cell, uniform_planes, dtype, scale_numbers=True)[:, :, 0, 0]
    return weigh(by_cell, _taken(tokens, local), local_planes) + once @ summed


def _taken(tokens: Array, places: list[int]) -> Array:
    """Returns the planes at some places of windows `[M, P, V, V]`."""
    return jnp.concatenate([tokens[:, place : place + 1] for place in places], axis=1)


def weigh(kernel: Array, tokens: Array, planes: Planes) -> Array:
    """Returns the channels of windows times a kernel: `[M, K]` of the kernel's dtype.

    Args:
      kernel: `[C * V * V, K]`.
      tokens: `[M, P, V, V]` uint8.
    """
    return _with_transpose(partial(_weigh, planes=planes), partial(_transpose, planes=planes))(
        kernel, tokens
    )


def _with_transpose(function: Linear, transpose: Linear) -> Linear:
    """Returns a linear function whose gradient is its transpose, and the other way round."""

    @jax.custom_vjp
    def apply(array: Array, tokens: Array) -> Array:
        return function(array, tokens)

    def forward(array: Array, tokens: Array) -> tuple[Array, Array]:
        return apply(array, tokens), tokens

    def backward(tokens: Array, gradient: Array) -> tuple[Array, None]:
        return _with_transpose(transpose, function)(gradient, tokens), None

    apply.defvjp(forward, backward)
    result: Linear = apply
    return result


def _weigh(kernel: Array, tokens: Array, planes: Planes) -> Array:
    """Returns what `weigh` does: by lookups on a CPU, as a product elsewhere."""
    result: Array = jax.lax.platform_dependent(
        tokens,
        kernel,
        cpu=kernel_by_kernel(partial(look_up, planes=planes)),
        default=partial(_multiply, planes=planes, multiple=ALIGNED),
    )
    return result


def _transpose(gradient: Array, tokens: Array, planes: Planes) -> Array:
    """Returns the kernel's gradient `[C * V * V, K]` from that of the result, `[M, K]`."""
    of_kernel: Array = jax.lax.platform_dependent(
        tokens,
        gradient,
        cpu=sequential_vmap(partial(look_up_gradient, planes=planes)),
        default=partial(_multiply_gradient, planes=planes, multiple=ALIGNED),
    )
    return of_kernel.astype(gradient.dtype)


def _multiply(tokens: Array, kernel: Array, planes: Planes, multiple: int = 1) -> Array:
    """Computes `weigh` as a product; `multiple`: of the rows of its matrices, see `ALIGNED`."""
    rows = jnp.pad(kernel, ((0, -kernel.shape[0] % multiple), (0, 0)))
    return _channels(tokens, planes, kernel.dtype, multiple) @ rows


def _multiply_gradient(tokens: Array, gradient: Array, planes: Planes, multiple: int = 1) -> Array:
    """Returns the kernel's gradient `[C * V * V, K]` float32; computing its transpose is faster."""
    channels = _channels(tokens, planes, gradient.dtype, multiple)
    transposed = jnp.matmul(gradient.T, channels, preferred_element_type=jnp.float32)
    return transposed.T[: _num_inputs(tokens, planes)]


def _channels(tokens: Array, planes: Planes, dtype: Any, multiple: int) -> Array:
    """Returns the channels of windows, flat, `[M, C * V * V]`, and zeros up to a multiple."""
    channels = to_channels(tokens, planes, dtype, scale_numbers=True)
    flat = channels.reshape(tokens.shape[0], _num_inputs(tokens, planes))
    return jnp.pad(flat, ((0, 0), (0, -flat.shape[1] % multiple)))


def look_up(tokens: Array, kernel: Array, planes: Planes) -> Array:
    """Computes `weigh` by lookups, with sums in float32."""
    windows = tokens.shape[0]
    width = kernel.shape[-1]
    cells = tokens.reshape(*tokens.shape[:2], -1)
    by_channel = kernel.astype(jnp.float32).reshape(-1, cells.shape[-1], width)
    rows = rows_by_plane(by_channel, planes)
    result = jnp.zeros((windows, width), jnp.float32)
    for group in groups_of(planes, windows):
        make_tables = jax.vmap(partial(make_table, group=group, planes=planes), in_axes=1)
        result = _add_rows(result, make_tables(rows), row_numbers(cells, group, planes))
    for place in _number_planes(planes):
        of_plane = (planes[place],)
        result = result + _multiply(tokens[:, place : place + 1], rows[place][0], of_plane)
    return result.astype(kernel.dtype)


def look_up_gradient(tokens: Array, gradient: Array, planes: Planes) -> Array:
    """Returns the kernel's gradient `[C * V * V, K]` float32 by lookups.

    The gradient of each window is added to the rows that its tokens select.
    """
    windows, width = gradient.shape
    cells = tokens.reshape(*tokens.shape[:2], -1)
    gradient = gradient.astype(jnp.float32)
    groups = groups_of(planes, windows)
    # One array for each plane: the transpose of slices of a single array would be a sum of as many
    # arrays of all channels.
    of_cell = [jax.ShapeDtypeStruct((len(plane.channels), width), jnp.float32) for plane in planes]
    # Tables are sums of rows, so the transpose of making them takes gradients of tables to
    # gradients of rows.
    to_rows = jax.linear_transpose(
        lambda rows: [make_table(rows, group, planes) for group in groups], of_cell
    )

    def add_cell(_: None, chosen: list[Array]) -> tuple[None, list[Array]]:
        """Returns the gradients of one cell's rows, `[L, K]` of each plane.

        chosen: of each group of planes, the row that each window selects, `[M]`.
        """
        tables = []
        for group, numbers in zip(groups, chosen, strict=True):
            table = jnp.zeros((rows_of(group, planes), width), jnp.float32)
            tables.append(table.at[numbers].add(gradient, mode="drop"))
        (of_planes,) = to_rows(tables)
        return None, of_planes

    chosen = [row_numbers(cells, group, planes) for group in groups]
    _, by_cell = jax.lax.scan(add_cell, None, chosen, length=cells.shape[-1])
    of_rows = [jnp.moveaxis(of_plane, 0, 1) for of_plane in by_cell]  # [L, cells, K] of each plane
    for place in _number_planes(planes):
        of_plane = (planes[place],)
        of_rows[place] = _multiply_gradient(tokens[:, place : place + 1], gradient, of_plane)[None]
    return jnp.concatenate(of_rows).reshape(-1, width)


def _number_planes(planes: Planes) -> list[int]:
    """Returns the indices of the number planes.

    Each is one channel, as a table can't have a row for every value.
    """
    return [place for place, plane in enumerate(planes) if plane.encoding == "number"]


def _add_rows(result: Array, tables: Array, numbers: Array) -> Array:
    """Adds to a result `[M, K]` the rows `[cells, M]` of tables `[cells, rows, K]`."""

    def add_cell(cell: Any, result: Array) -> Array:
        table: Array = jax.lax.dynamic_index_in_dim(tables, cell, keepdims=False)
        chosen = jax.lax.dynamic_index_in_dim(numbers, cell, keepdims=False)
        return result + table.at[chosen].get(mode="clip")

    def add_cells(step: Array, result: Array) -> Array:
        for place in range(CELLS):
            result = add_cell(CELLS * step + place, result)
        return result

    cells = len(tables)
    result = jax.lax.fori_loop(0, cells // CELLS, add_cells, result)
    for cell in range(cells // CELLS * CELLS, cells):
        result = add_cell(cell, result)
    return result

"""The first dense layer of a network that reads windows of tokens flat.

It is a sum of looked-up rows on a CPU, a product elsewhere. Its input has a channel for each value
that a token can have, and is almost all zeros. On a CPU, a loop over the cells of a window looks up
the rows of the kernel for the cell's content, in all windows at once, and adds them. That is
several times as fast as the product (docs/performance.md). GPUs are better at products.
"""

import math
from collections.abc import Callable
from functools import cache, partial
from typing import Any

import flax.linen as nn
import jax
import jax.numpy as jnp
from jax import Array

from sjdsl.runtime.tokens import to_channels

from .initialisation import orthogonal
from .window_rows import Planes, groups_of, make_tables, row_numbers, rows_by_plane, rows_of

# Numbers in a row of a matrix, or a multiple of them: for a GPU, XLA copies other rows to longer
# ones.
ALIGNED = 8
CELLS = 4  # cells whose rows are added in one pass over the windows; measured (docs/performance.md)


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
    """Returns some planes of windows `[M, P, V, V]`."""
    return jnp.concatenate([tokens[:, place : place + 1] for place in places], axis=1)


@partial(jax.custom_vjp, nondiff_argnums=(2,))
def weigh(kernel: Array, tokens: Array, planes: Planes) -> Array:
    """Returns the channels of windows times a kernel: `[M, K]` of the kernel's dtype.

    Args:
      kernel: `[C * V * V, K]`.
      tokens: `[M, P, V, V]` uint8.
    """
    result: Array = jax.lax.platform_dependent(
        kernel,
        tokens,
        cpu=partial(look_up, planes=planes),
        default=partial(_multiply, planes=planes, multiple=ALIGNED),
    )
    return result


def _forward(kernel: Array, tokens: Array, planes: Planes) -> tuple[Array, tuple[Array, Array]]:
    return weigh(kernel, tokens, planes), (kernel, tokens)


def _backward(planes: Planes, inputs: tuple[Array, Array], gradient: Array) -> tuple[Array, None]:
    kernel, tokens = inputs
    return weigh_gradient(gradient, tokens, planes).astype(kernel.dtype), None


weigh.defvjp(_forward, _backward)


@partial(jax.custom_vjp, nondiff_argnums=(2,))
def weigh_gradient(gradient: Array, tokens: Array, planes: Planes) -> Array:
    """Returns the kernel's gradient `[C * V * V, K]` float32 from the result's `[M, K]`.

    It is the transpose of `weigh`, and vice versa.
    """
    result: Array = jax.lax.platform_dependent(
        tokens,
        gradient,
        cpu=partial(look_up_gradient, planes=planes),
        default=partial(_multiply_gradient, planes=planes, multiple=ALIGNED),
    )
    return result


def _forward_gradient(
    gradient: Array, tokens: Array, planes: Planes
) -> tuple[Array, tuple[Array, Array]]:
    return weigh_gradient(gradient, tokens, planes), (gradient, tokens)


def _backward_gradient(
    planes: Planes, inputs: tuple[Array, Array], of_kernel: Array
) -> tuple[Array, None]:
    gradient, tokens = inputs
    return weigh(of_kernel.astype(gradient.dtype), tokens, planes), None


weigh_gradient.defvjp(_forward_gradient, _backward_gradient)


def _multiply(kernel: Array, tokens: Array, planes: Planes, multiple: int = 1) -> Array:
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


def look_up(kernel: Array, tokens: Array, planes: Planes) -> Array:
    """Computes `weigh` by lookups, with sums in float32."""
    result: Array = _look_up(planes)(kernel[None], tokens[None])[0]
    return result


def look_up_gradient(tokens: Array, gradient: Array, planes: Planes) -> Array:
    """Computes `weigh_gradient` by lookups."""
    result: Array = _look_up_gradient(planes)(tokens[None], gradient[None])[0]
    return result


@cache
def _look_up(planes: Planes) -> Callable[[Array, Array], Array]:
    """Returns the lookups of G networks, `[G, M, K]`.

    They take kernels `[G, C * V * V, K]` and windows `[G, M, P, V, V]`. Under `vmap` the new axis
    becomes more networks: XLA would give tables with a leading axis another layout, and copy them
    in every step.
    """

    @jax.custom_batching.custom_vmap
    def look_up(kernels: Array, tokens: Array) -> Array:
        """Adds up the rows that the tokens of each window select."""
        number, windows = tokens.shape[:2]
        cells = _by_cell(tokens)
        width = kernels.shape[-1]
        by_channel = _by_channel(kernels, cells.shape[-1]).astype(jnp.float32)
        rows = rows_by_plane(by_channel, planes)
        result = jnp.zeros((number * windows, width), jnp.float32)
        for group in groups_of(planes, windows):
            tables = make_tables(rows, group, planes)
            result = _add_rows(result, tables, row_numbers(cells, group, planes))
        result = result.reshape(number, windows, width)
        for place in _number_planes(planes):
            of_plane = jnp.moveaxis(rows[place][0], 1, 0)
            multiply = jax.vmap(partial(_multiply, planes=(planes[place],)))
            result = result + multiply(of_plane, tokens[:, :, place : place + 1])
        return result.astype(kernels.dtype)

    @look_up.def_vmap
    def look_up_more(
        size: int, batched: list[bool], kernels: Array, tokens: Array
    ) -> tuple[Array, bool]:
        """Looks up under `vmap`: a batch of kernels is more networks, a batch of windows is more
        windows.
        """
        kernels_batched, tokens_batched = batched
        if kernels_batched:
            all_kernels = _merge(kernels, True, size)
            result = look_up(all_kernels, _merge(tokens, tokens_batched, size))
            return _split(result, size), True
        windows = jnp.moveaxis(tokens, 0, 1)  # of the same networks
        networks, _, number = windows.shape[:3]
        result = look_up(kernels, windows.reshape(networks, size * number, *windows.shape[3:]))
        return jnp.moveaxis(result.reshape(networks, size, number, -1), 1, 0), True

    return look_up


@cache
def _look_up_gradient(planes: Planes) -> Callable[[Array, Array], Array]:
    """Returns the gradients of the lookups of G networks, `[G, C * V * V, K]`.

    They take windows `[G, M, P, V, V]` and gradients `[G, M, K]`.
    """

    @jax.custom_batching.custom_vmap
    def look_up_gradient(tokens: Array, gradients: Array) -> Array:
        """Adds each window's gradient to the rows that its tokens select."""
        number, windows, width = gradients.shape
        cells = _by_cell(tokens)
        gradients = gradients.astype(jnp.float32)
        groups = groups_of(planes, windows)
        flat = gradients.reshape(number * windows, width)
        # One array for each plane: the transpose of slices of a single array would be a sum of as
        # many arrays of all channels.
        of_cell = [
            jax.ShapeDtypeStruct((len(plane.channels), 1, number, width), jnp.float32)
            for plane in planes
        ]
        # Tables are sums of rows, so the transpose of making them takes gradients of tables to
        # gradients of rows.
        to_rows = jax.linear_transpose(
            lambda rows: [make_tables(rows, group, planes) for group in groups], of_cell
        )

        def add_cell(_: None, chosen: list[Array]) -> tuple[None, list[Array]]:
            """Returns the gradients of one cell's rows, `[L, G, K]` of each plane.

            chosen: of each group of planes, the row that each window selects, `[G * M]`.
            """
            tables = []
            for group, numbers in zip(groups, chosen, strict=True):
                table = jnp.zeros((number * rows_of(group, planes), width), jnp.float32)
                tables.append(table.at[numbers].add(flat, mode="drop")[None])
            (of_planes,) = to_rows(tables)
            return None, [of_plane[:, 0] for of_plane in of_planes]

        chosen = [row_numbers(cells, group, planes) for group in groups]
        _, by_cell = jax.lax.scan(add_cell, None, chosen, length=cells.shape[-1])
        # [L, cells, G, K] of each plane
        of_rows = [jnp.moveaxis(of_plane, 0, 1) for of_plane in by_cell]
        for place in _number_planes(planes):
            multiply = jax.vmap(partial(_multiply_gradient, planes=(planes[place],)))
            of_plane = multiply(tokens[:, :, place : place + 1], gradients)
            of_rows[place] = jnp.moveaxis(of_plane, 1, 0)[None]
        return jnp.moveaxis(jnp.concatenate(of_rows), 2, 0).reshape(number, -1, width)

    @look_up_gradient.def_vmap
    def look_up_more(
        size: int, batched: list[bool], tokens: Array, gradients: Array
    ) -> tuple[Array, bool]:
        """Looks up under `vmap`: the batch is more networks."""
        tokens_batched, gradients_batched = batched
        all_tokens = _merge(tokens, tokens_batched, size)
        all_gradients = _merge(gradients, gradients_batched, size)
        return _split(look_up_gradient(all_tokens, all_gradients), size), True

    return look_up_gradient


def _merge(array: Array, batched: bool, size: int) -> Array:
    """Returns an array `[G, ...]`, or if batched `[size, G, ...]`, as `[size * G, ...]`."""
    whole = array if batched else jnp.broadcast_to(array, (size, *array.shape))
    return whole.reshape(size * whole.shape[1], *whole.shape[2:])


def _split(array: Array, size: int) -> Array:
    """Returns an array `[size * G, ...]` as `[size, G, ...]`."""
    return array.reshape(size, array.shape[0] // size, *array.shape[1:])


def _by_channel(kernels: Array, cells: int) -> Array:
    """Returns kernels `[G, C * cells, K]` as `[C, cells, G, K]`."""
    return jnp.moveaxis(kernels.reshape(kernels.shape[0], -1, cells, kernels.shape[-1]), 0, 2)


def _by_cell(tokens: Array) -> Array:
    """Returns windows `[G, M, P, V, V]` as `[G, M, P, cells]`."""
    return tokens.reshape(*tokens.shape[:3], math.prod(tokens.shape[3:]))


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

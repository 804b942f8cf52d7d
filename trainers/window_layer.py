"""The first dense layer of a network that reads windows of tokens flat, in pieces that a core's cache holds.

Its input, a channel for each value a token can have, is by far the largest array of a gradient step: 47 MB for 7,000 windows
of Commons Harvest, which a CPU would write once and read twice. Made piece by piece, and made again for the gradient, it never
leaves the cache. Other devices have it in one piece.
"""

import math
from functools import partial
from typing import Any

import flax.linen as nn
import jax
import jax.numpy as jnp
from jax import Array

from sjdsl.runtime.planes import TokenPlane
from sjdsl.runtime.tokens import to_channels

from .initialisation import orthogonal

PIECE = 3_000_000  # bytes of a piece's channels: half of it was as good, twice as much was not
FEWEST_PIECES = 4  # fewer are no faster than the whole, which a larger cache holds
FEWEST_WINDOWS = 128  # of a piece: fewer, of large windows, would read the kernel too often

Planes = tuple[TokenPlane, ...]


class WindowLayer(nn.Module):
    """A dense layer on the channels of windows, as `nn.Dense` would be on them, with its parameters and their names."""

    width: int
    planes: Planes
    gain: float
    dtype: Any

    @nn.compact
    def __call__(self, tokens: Array) -> Array:
        """Returns `[..., width]` of windows `[..., P, V, V]` uint8."""
        lead, window = tokens.shape[:-3], tokens.shape[-3:]
        inputs = jax.eval_shape(lambda one: _channels(one, self.planes, self.dtype), jax.ShapeDtypeStruct((1, *window), tokens.dtype))
        kernel = self.param("kernel", orthogonal(self.gain), (inputs.shape[1], self.width))
        bias = self.param("bias", nn.initializers.zeros, (self.width,))
        result: Array = weigh(kernel.astype(self.dtype), tokens.reshape(-1, *window), self.planes) + bias.astype(self.dtype)
        return result.reshape(*lead, self.width)


@partial(jax.custom_vjp, nondiff_argnums=(2,))
def weigh(kernel: Array, tokens: Array, planes: Planes) -> Array:
    """Returns the channels of windows `[M, P, V, V]` uint8 times a kernel `[C * V * V, K]`: `[M, K]` of the kernel's dtype."""
    result: Array = jax.lax.platform_dependent(
        kernel, tokens, cpu=partial(_weigh_pieces, planes=planes), default=partial(_weigh_all, planes=planes)
    )
    return result


def _forward(kernel: Array, tokens: Array, planes: Planes) -> tuple[Array, tuple[Array, Array]]:
    return weigh(kernel, tokens, planes), (kernel, tokens)


def _backward(planes: Planes, inputs: tuple[Array, Array], gradient: Array) -> tuple[Array, None]:
    kernel, tokens = inputs
    of_kernel: Array = jax.lax.platform_dependent(
        tokens, gradient, cpu=partial(_gradient_of_pieces, planes=planes), default=partial(_gradient_of_all, planes=planes)
    )
    return of_kernel.T.astype(kernel.dtype), None


weigh.defvjp(_forward, _backward)


def _channels(tokens: Array, planes: Planes, dtype: Any) -> Array:
    """Returns the channels of windows, flat: `[M, C * V * V]`."""
    channels = to_channels(tokens, planes, dtype, scale_numbers=True)
    return channels.reshape(tokens.shape[0], math.prod(channels.shape[1:]))  # not -1: there may be no windows


def _weigh_all(kernel: Array, tokens: Array, planes: Planes) -> Array:
    return _channels(tokens, planes, kernel.dtype) @ kernel


def _gradient_of_all(tokens: Array, gradient: Array, planes: Planes) -> Array:
    """Returns the kernel's gradient, transposed `[K, C * V * V]`, which is faster to make; float32, for pieces are added up."""
    return jnp.matmul(gradient.T, _channels(tokens, planes, gradient.dtype), preferred_element_type=jnp.float32)


def _weigh_pieces(kernel: Array, tokens: Array, planes: Planes) -> Array:
    number, length = _pieces(tokens.shape[0], kernel.shape[0], kernel.dtype)
    if number < FEWEST_PIECES:
        return _weigh_all(kernel, tokens, planes)
    body, rest = _cut(tokens, number, length)
    done = jax.lax.map(lambda piece: _weigh_all(kernel, piece, planes), body)
    return jnp.concatenate([done.reshape(number * length, -1), _weigh_all(kernel, rest, planes)])


def _gradient_of_pieces(tokens: Array, gradient: Array, planes: Planes) -> Array:
    inputs = jax.eval_shape(lambda tokens: _channels(tokens, planes, gradient.dtype), tokens).shape[1]
    number, length = _pieces(tokens.shape[0], inputs, gradient.dtype)
    if number < FEWEST_PIECES:
        return _gradient_of_all(tokens, gradient, planes)
    (tokens, rest), (gradient, rest_gradient) = _cut(tokens, number, length), _cut(gradient, number, length)

    def add_piece(total: Array, piece: tuple[Array, Array]) -> tuple[Array, None]:
        return total + _gradient_of_all(*piece, planes), None

    total, _ = jax.lax.scan(add_piece, _gradient_of_all(rest, rest_gradient, planes), (tokens, gradient))
    return total


def _pieces(windows: int, inputs: int, dtype: Any) -> tuple[int, int]:
    """Returns how many whole pieces there are, 0 where they would be too small, and how many windows each has."""
    length = PIECE // (inputs * jnp.dtype(dtype).itemsize)
    return (windows // length if length >= FEWEST_WINDOWS else 0), length


def _cut(array: Array, number: int, length: int) -> tuple[Array, Array]:
    """Returns the pieces `[number, length, ...]`, and what is left, which may be empty."""
    whole = number * length
    return array[:whole].reshape(number, length, *array.shape[1:]), array[whole:]

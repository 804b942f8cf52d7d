"""The one-hot form of token planes: the same information, a channel for each value."""

import jax.numpy as jnp
from jax import Array

from sjdsl.runtime.planes import TokenPlane, channel_names

__all__ = ["TokenPlane", "channel_names", "to_channels"]


def to_channels(tokens: Array, planes: tuple[TokenPlane, ...], dtype: jnp.dtype, scale_numbers: bool = False) -> Array:
    """Returns the one-hot form of token planes.

    Args:
      tokens: `[..., P]` uint8, one plane a position of the last axis.
      planes: the P planes' meanings.
      dtype: dtype of the result.
      scale_numbers: divide number planes by their `high`, for networks; needs a floating dtype.
    Returns:
      `[..., C]` of `dtype`; C is `len(channel_names(planes))`.
    """
    if tokens.shape[-1] != len(planes):
        raise ValueError(f"tokens have {tokens.shape[-1]} planes, {len(planes)} are described")
    columns = []
    for index, plane in enumerate(planes):
        value = tokens[..., index, None]
        match plane.encoding:
            case "word":
                columns.append((value == _numbers(plane, tokens)).astype(dtype))
            case "bits":
                columns.append(((value >> _numbers(plane, tokens)) & jnp.uint8(1)).astype(dtype))
            case "number":
                scaled = value.astype(dtype)
                columns.append(scaled / jnp.asarray(plane.high, dtype) if scale_numbers else scaled)
    return jnp.concatenate(columns, axis=-1)


def _numbers(plane: TokenPlane, tokens: Array) -> Array:
    """Returns 0, 1, … for the labels of a plane, shaped to stand beside the tokens."""
    numbers = jnp.arange(len(plane.labels), dtype=tokens.dtype)
    return numbers.reshape((1,) * (tokens.ndim - 1) + (-1,))

"""One-hot encoding of token planes: the same information with a channel for each value."""

import jax.numpy as jnp
from jax import Array

from sjdsl.runtime.planes import TokenPlane


def to_channels(
    tokens: Array, planes: tuple[TokenPlane, ...], dtype: jnp.dtype, scale_numbers: bool = False
) -> Array:
    """Returns the one-hot form of token planes.

    Args:
      tokens: `[..., P, rows, cols]` uint8.
      planes: the P planes' meanings.
      dtype: dtype of the result.
      scale_numbers: divide number planes by their `high`, for networks; needs a floating dtype.
    Returns:
      `[..., C, rows, cols]` of `dtype`; C is `len(channel_names(planes))`.
    Raises:
      ValueError: not as many planes as are described.
    """
    *lead, number, rows, cols = tokens.shape
    if number != len(planes):
        raise ValueError(f"tokens have {number} planes, {len(planes)} are described")
    # In one axis: rows would be too short for vector instructions.
    cells = tokens.reshape(*lead, number, rows * cols)
    channels = []
    for index, plane in enumerate(planes):
        value = cells[..., index, :]
        match plane.encoding:
            case "word":
                for label in range(len(plane.labels)):
                    channels.append((value == jnp.uint8(label)).astype(dtype))
            case "bits":
                for label in range(len(plane.labels)):
                    bit = (value >> jnp.uint8(label)) & jnp.uint8(1)
                    channels.append(bit.astype(dtype))
            case "number":
                numbers = value.astype(dtype)
                if scale_numbers:
                    numbers = numbers / jnp.asarray(plane.high, dtype)
                channels.append(numbers)
    return jnp.concatenate(channels, axis=-1).reshape(*lead, len(channels), rows, cols)

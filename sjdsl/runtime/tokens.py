"""Token planes: what each byte of a `tokens` observation means, and the one-hot form of the same information."""

from dataclasses import dataclass
from typing import Literal

import jax.numpy as jnp
from jax import Array


@dataclass(frozen=True)
class TokenPlane:
    """One uint8 plane of an observation.

    encoding `word`: value v means `labels[v]`; `bits`: bit k means `labels[k]`; `number`: the value itself, 0 .. `high`.
    """

    name: str
    encoding: Literal["word", "bits", "number"]
    labels: tuple[str, ...] = ()
    high: int = 0

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the one-hot channels this plane becomes, in order."""
        if self.encoding == "number":
            return (self.name,)
        return tuple(f"{self.name}: {label}" for label in self.labels)


def channel_names(planes: tuple[TokenPlane, ...]) -> tuple[str, ...]:
    """Returns the names of all one-hot channels, plane by plane."""
    return tuple(name for plane in planes for name in plane.channels)


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

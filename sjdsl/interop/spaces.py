"""Spaces in the manner of gymnax, for adapters whose library is not installed with them."""

from dataclasses import dataclass

import jax
import jax.numpy as jnp
from jax import Array


@dataclass(frozen=True)
class Discrete:
    """The integers 0 .. n - 1."""

    n: int
    shape: tuple[int, ...] = ()
    dtype = jnp.int32

    def sample(self, key: Array) -> Array:
        """Returns one of them, each with equal probability."""
        return jax.random.randint(key, self.shape, 0, self.n, self.dtype)

    def contains(self, x: Array) -> Array:
        """Returns whether a number is one of them."""
        return (x >= 0) & (x < self.n)


@dataclass(frozen=True)
class Box:
    """Arrays of a shape with entries from `low` to `high`, float32."""

    low: float
    high: float
    shape: tuple[int, ...]
    dtype = jnp.float32

    def sample(self, key: Array) -> Array:
        """Returns an array with even entries."""
        return jax.random.uniform(key, self.shape, self.dtype, self.low, self.high)

    def contains(self, x: Array) -> Array:
        """Returns whether all entries are within the bounds."""
        return jnp.all((x >= self.low) & (x <= self.high))

"""Bounds of observations, and the spaces of the SocialJax adapter.

Its library needn't be installed.
"""

import importlib
import warnings
from dataclasses import dataclass
from functools import cache
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from sjdsl.runtime.env import Environment

SUITE = "socialjax.environments.spaces"


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


def channel_bounds(env: Environment) -> np.ndarray:
    """Returns the greatest value of each channel of an observation, `[C]` uint8; the least is 0.

    A channel of one-hot observations is 0 or 1, but for that of a number, which has its values.
    """
    if env.observation == "tokens":
        return np.array([plane.high for plane in env.token_planes], np.uint8)
    bounds: list[int] = []
    for plane in env.token_planes:
        bound = plane.high if plane.encoding == "number" else 1
        bounds += [bound] * len(plane.channels)
    return np.array(bounds, np.uint8)


def window_high(env: Environment) -> np.ndarray:
    """Returns the greatest values in an agent's window, `[rows, cols, channels]` uint8."""
    _, _, rows, cols = env.observation_shape
    highs = channel_bounds(env)
    return np.broadcast_to(highs, (rows, cols, len(highs))).copy()


def make_box(low: float, high: float, shape: tuple[int, ...]) -> Any:
    """Returns a float32 box of the class that SocialJax's own wrappers test for.

    It is ours if SocialJax isn't installed.
    """
    box, _ = space_classes()
    return box(low, high, shape)


def make_discrete(n: int) -> Any:
    """Returns the integers 0 .. n - 1, int32, of the class that `make_box` would choose."""
    _, discrete = space_classes()
    space = discrete(n)
    if space.dtype != jnp.int32:  # the suite's samples 64 bits, which JAX warns of
        space.dtype = jnp.int32
    return space


@cache
def space_classes() -> tuple[type, type]:
    """Returns the classes of boxes and of discrete spaces.

    SocialJax's, or ours if it isn't installed.

    Warns about a SocialJax that is installed but can't be imported, such as an old one with a new
    JAX, and returns ours.
    """
    try:
        module = importlib.import_module(SUITE)
        return module.Box, module.Discrete
    except ModuleNotFoundError:
        pass
    except Exception as error:
        warnings.warn(
            f"{SUITE} is installed but cannot be imported ({type(error).__name__}: {error}); "
            "its spaces are not used",
            stacklevel=2,
        )
    return Box, Discrete

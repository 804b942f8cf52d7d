"""Orthogonal weight initialisation by the Gram-Schmidt procedure, without LAPACK.

JAX's own initialiser uses a QR decomposition, for which XLA's CPU client calls LAPACK. Several at
once, with OpenBLAS's threads, can deadlock (JAX 0.10, scipy 1.17: a program with five of them
within sixty runs). The Gram-Schmidt procedure needs only products.
"""

import math
from collections.abc import Sequence
from typing import Any

import jax
import jax.numpy as jnp
from flax.linen.initializers import Initializer
from jax import Array


def orthogonal(gain: float = 1.0) -> Initializer:
    """Returns the initialiser of matrices with orthogonal columns of length `gain`.

    Rows are orthogonal if there are fewer of them. Leading axes count as rows. Source: Saxe et al.
    2014, "Exact solutions to the nonlinear dynamics of learning in deep linear networks".
    """

    def init(key: Array, shape: Sequence[int], dtype: Any = jnp.float32) -> Array:
        """Returns an orthogonal matrix in the shape of the weights."""
        cols = shape[-1]
        rows = math.prod(shape[:-1])
        drawn = jax.random.normal(key, (max(rows, cols), min(rows, cols)), jnp.float32)
        columns = orthonormal_columns(drawn)
        matrix = columns if rows >= cols else columns.T
        return (gain * matrix).reshape(tuple(shape)).astype(dtype)

    return init


def orthonormal_columns(matrix: Array) -> Array:
    """Returns the columns `[R, C]`, R >= C, made orthogonal to those before and of length one.

    They are uniform if the entries are normal. Each is freed of the others twice: once leaves
    errors of rounding.
    """

    def free(number: Array, done: Array) -> Array:
        column = matrix[:, number]
        for _ in range(2):
            column = column - done @ (done.T @ column)
        return done.at[:, number].set(column / jnp.linalg.norm(column))

    result: Array = jax.lax.fori_loop(0, matrix.shape[1], free, jnp.zeros_like(matrix))
    return result

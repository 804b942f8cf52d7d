"""Equality of returns against figures worked out by hand, and against the other formula for it."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from sjdsl.runtime.returns import collective_return, equality

# returns -> 1 - sum of |a - b| over all ordered pairs / (2 N sum)
BY_HAND = [
    ([2, 2], 1),
    ([4, 0], 1 / 2),  # 1 - 8 / 16
    ([3, 1], 3 / 4),  # 1 - 4 / 16
    ([6, 3, 0], 5 / 9),  # 1 - 24 / 54
    ([1, 0, 0, 0, 0], 1 / 5),  # one has everything: 1 / N
    ([0.5, 0.5, 0.5], 1),
    ([7], 1),
    ([0, 0], np.nan),
    ([5, -1], np.nan),
    ([-1, -1], np.nan),
]


@pytest.mark.parametrize(("returns", "wanted"), BY_HAND)
def test_equality_by_hand(returns: list[float], wanted: float) -> None:
    for arrays in (np, jnp):
        np.testing.assert_allclose(
            equality(arrays.asarray(returns, arrays.float32)), wanted, rtol=1e-6
        )


def test_collective_return() -> None:
    assert collective_return(np.array([[1.0, -2.0], [3.0, 4.0]])).tolist() == [-1, 7]


def test_equality_of_many_episodes() -> None:
    """1 - G with G = sum over i of (2 i - N - 1) x_i / (N sum x), x in ascending order, i from 1; units and order do not matter."""
    returns = np.random.default_rng(0).exponential(size=(50, 7)).astype(np.float32)
    number = returns.shape[1]
    ranks = 2 * np.arange(1, number + 1) - number - 1
    wanted = 1 - (np.sort(returns, axis=1) * ranks).sum(axis=1) / (number * returns.sum(axis=1))
    np.testing.assert_allclose(equality(returns), wanted, rtol=1e-5)
    np.testing.assert_allclose(jax.jit(jax.vmap(equality))(jnp.asarray(returns)), wanted, rtol=1e-5)
    np.testing.assert_allclose(equality(10 * returns[:, ::-1]), wanted, rtol=1e-5)
    assert ((wanted > 1 / number) & (wanted < 1)).all()

"""Exact arithmetic of reals against NumPy and exact fractions; quotients in the form for GPUs bit by bit."""

import math
from fractions import Fraction
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from sjdsl.runtime.exact_reals import divided, exact_mix, exact_sum, exactly, fixed_point, rounded
from sjdsl.runtime.forms import forced

F = np.float32
LEAST, GREATEST = F(2.0**-126), F(2**24 - 1) * F(2.0**104)
FRACTIONS = np.array(
    [0, 1, 2, 3, 2**22, 2**22 + 1, 2**23 - 2, 2**23 - 1], np.uint32
)  # of floats whose quotients are hard to round


def reals(number: int, exponents: tuple[int, int], seed: int) -> Any:
    """Returns normal float32s of both signs, a third of them with a fraction of `FRACTIONS`."""
    random = np.random.default_rng(seed)
    exponent = random.integers(*exponents, number).astype(np.uint32)
    fraction = random.integers(0, 2**23, number).astype(np.uint32)
    fraction = np.where(random.random(number) < 1 / 3, random.choice(FRACTIONS, number), fraction)
    sign = random.integers(0, 2, number).astype(np.uint32)
    return (sign << 31 | exponent << 23 | fraction).view(F)


def bits(values: Any) -> Any:
    return np.asarray(values).view(np.uint32)


def quotients(form: str, dividend: Any, divisor: Any) -> Any:
    with forced(form):
        return np.asarray(jax.jit(divided)(dividend, divisor))


@pytest.mark.parametrize("form", ["cpu", "gpu"])
def test_quotients_are_correctly_rounded(form: str) -> None:
    """Of numbers with any exponents, of whole numbers, of products and their factors, and of what is next to a product."""
    whole = np.arange(1, 700, dtype=F)
    some, others = reals(200_000, (64, 190), 0), reals(200_000, (64, 190), 1)
    near = reals(100_000, (120, 134), 2)
    pairs = [
        (reals(200_000, (1, 255), 3), reals(200_000, (1, 255), 4)),
        (some, others),
        tuple(map(np.ravel, np.meshgrid(whole, whole))),
        (near * near[::-1], near),
        (np.nextafter(near * near[::-1], F(np.inf)), near[::-1]),
    ]
    for dividend, divisor in pairs:
        with np.errstate(over="ignore", under="ignore"):
            expected = dividend / divisor
        exact = dividend.astype(float) / divisor
        expected = np.where(np.abs(exact) < LEAST, np.copysign(F(0), expected), expected)
        np.testing.assert_array_equal(bits(quotients(form, dividend, divisor)), bits(expected))


@pytest.mark.parametrize("form", ["cpu", "gpu"])
def test_quotients_of_nought_and_infinity(form: str) -> None:
    values = np.array([0.0, -0.0, np.inf, -np.inf, np.nan, 1, -3, GREATEST, LEAST], F)
    dividend, divisor = map(np.ravel, np.meshgrid(values, values))
    with np.errstate(all="ignore"):
        expected = dividend / divisor
    expected[np.abs(expected) < LEAST] *= 0
    np.testing.assert_array_equal(quotients(form, dividend, divisor), expected)


def nearest(terms: Any) -> Any:
    """Returns the float32 nearest to the exact sum of numbers, of two the even one; 0 for what is below all normal ones."""
    exact = sum(map(Fraction, map(float, terms)))
    if abs(exact) < Fraction(2) ** -126:
        return F(0)
    last_bit = Fraction(2) ** (math.frexp(float(exact))[1] - 24)
    with np.errstate(over="ignore"):
        return F(float(round(exact / last_bit) * last_bit))


@pytest.mark.parametrize(
    "exponents", [(126, 128), (120, 131), (100, 150), (1, 40), (1, 250), (230, 255)], ids=str
)
def test_sums_are_rounded_once_in_any_order(exponents: tuple[int, int]) -> None:
    """Some of the terms cancel each other."""
    values = reals(200 * 24, exponents, exponents[0]).reshape(200, 24)
    values[::2, 12:] = -values[::2, :12]
    values[::2, 3] = 0
    expected = np.array([nearest(row) for row in values])
    np.testing.assert_array_equal(exact_sum(values, 1), expected)
    np.testing.assert_array_equal(exact_sum(values[:, ::-1].reshape(200, 4, 6), (1, 2)), expected)
    apart = fixed_point(values[:, 0]) + jnp.sum(fixed_point(values[:, 1:]), axis=1, dtype=jnp.int32)
    np.testing.assert_array_equal(rounded(apart), expected)


HALF = 2.0**-24  # of the last bit of numbers from 1 on
TIES = [
    (1, HALF),
    (1, HALF, 2.0**-100),
    (1, 3 * HALF),
    (1, 3 * HALF, -(2.0**-100)),
    (-1, -HALF),
    (2.0**24, 1, LEAST),
    (2 - 2 * HALF, HALF),
]
FAR = [
    (GREATEST, GREATEST, -GREATEST),
    (GREATEST, GREATEST),
    (-GREATEST, -GREATEST),
    (GREATEST, 2.0**103),
    (GREATEST, 2.0**102),
]


@pytest.mark.parametrize(
    "terms", [*TIES, *FAR, (LEAST, -LEAST), (1.5 * LEAST, -LEAST), (0, -0.0)], ids=str
)
def test_sums_halfway_and_at_the_ends(terms: tuple[float, ...]) -> None:
    assert float(exact_sum(jnp.array(terms, jnp.float32), 0)) == float(nearest(terms))


def test_sums_with_infinity_are_infinite() -> None:
    assert exact_sum(jnp.array([np.inf, -GREATEST, -GREATEST]), 0) == np.inf
    assert exact_sum(jnp.array([-np.inf, GREATEST]), 0) == -np.inf


def test_as_many_terms_as_are_allowed() -> None:
    values = np.full(2**19 - 1, GREATEST * F(2.0**-20), F)
    assert float(exact_sum(values, 0)) == float(F(float(values[0]) * (2**19 - 1)))


def test_a_number_stays_as_it_is() -> None:
    values = np.concatenate([reals(5000, (1, 255), 9), np.array([0.0, -0.0, np.inf, -np.inf], F)])
    np.testing.assert_array_equal(bits(jax.jit(exactly)(values)), bits(values))


def test_shares_are_correctly_rounded() -> None:
    rows = np.random.default_rng(3).integers(0, 9, (500, 3))
    rows[:, 0] += 1
    expected = rows.astype(F) / rows.sum(axis=1, keepdims=True).astype(F)
    for form in ("cpu", "gpu"):
        with forced(form):
            np.testing.assert_array_equal(jax.jit(exact_mix)(jnp.asarray(rows)), expected)
    np.testing.assert_array_equal(exact_mix(jnp.zeros((2, 3), jnp.int32)), np.zeros((2, 3)))

"""Reals of the interpreter: sums that are exact and rounded once, and numbers next to 0."""

import numpy as np
import pytest

from sjdsl.interpreter.numbers import added_up, arithmetic, real

BIT = 2.0**-23  # the last of numbers from 1 on


@pytest.mark.parametrize(
    ("terms", "total"),
    [
        ((1, BIT / 2), 1),
        ((1, BIT / 2, 2.0**-80), 1 + BIT),  # a float64 can't tell from the half
        ((1, BIT, BIT / 2, -(2.0**-80)), 1 + BIT),
        ((-1, -BIT / 2, -(2.0**-80)), -1 - BIT),
        ((2.0**60, 1, -(2.0**60)), 1),
        ((0.1, 0.2, 0.3), float(np.float32(0.6))),
    ],
)
def test_sums_are_rounded_once(terms: tuple[float, ...], total: float) -> None:
    assert float(added_up(terms)) == total
    assert float(added_up(terms[::-1])) == total


def test_what_is_nearer_to_nought_than_normal_numbers_is_nought() -> None:
    least = np.float32(2.0**-126)
    assert real(least) == least
    assert real((least / 2, -least, 1)) == (0, -least, 1)
    assert real(arithmetic("*", [least, 0.5], is_real=True)) == 0

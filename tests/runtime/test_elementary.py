"""Roots, exponentials and logarithms against NumPy's float64, and against the interpreter bit by bit, in both forms."""

from typing import Any

import jax
import numpy as np
import pytest

from sjdsl.interpreter import numbers
from sjdsl.runtime.elementary import exact_root, exponential, logarithm, powered
from sjdsl.runtime.forms import forced

F = np.float32
LEAST = F(2.0**-126)
both_forms = pytest.mark.parametrize("form", ["cpu", "gpu"])


def bits(values: Any) -> Any:
    return np.asarray(values, F).view(np.uint32)


def positive(number: int, seed: int) -> Any:
    """Returns normal float32s of all sizes, and many next to 1 and to powers of 2."""
    random = np.random.default_rng(seed)
    any_size = random.integers(0x00800000, 0x7F800000, number, np.uint32).view(F)
    near_1 = (1 + random.normal(0, 0.01, number)).astype(F)
    near_powers = bits(2.0 ** np.arange(-125, 127)) + random.integers(-3, 4, 252).astype(np.uint32)
    return np.concatenate([any_size, near_1, near_powers.view(F), [LEAST, F(1), F(4)]])


def exponents(number: int, seed: int) -> Any:
    random = np.random.default_rng(seed)
    ends = [0, -0.0, 88, -87.3, -87.4, -104, -1e30, 1e-30, -1e-30]
    parts = [random.uniform(-110, 88, number), random.uniform(-1, 1, number), ends]
    return np.concatenate(parts).astype(F)


def computed(kernel: Any, form: str, values: Any) -> Any:
    with forced(form):
        return np.asarray(jax.jit(lambda x: kernel(x))(values))


@both_forms
def test_roots_are_correctly_rounded(form: str) -> None:
    values = positive(300_000, 0)
    np.testing.assert_array_equal(bits(computed(exact_root, form, values)), bits(np.sqrt(values)))
    odd = np.array([0, -0.0, -1e-6, np.inf, np.nan], F)
    np.testing.assert_array_equal(computed(exact_root, form, odd), [0, 0, 0, np.inf, np.nan])


@both_forms
@pytest.mark.parametrize(
    ("kernel", "interpreted", "exact", "values"),
    [
        (exponential, numbers.exponential, np.exp, exponents),
        (logarithm, numbers.logarithm, np.log, positive),
    ],
    ids=["exp", "log"],
)
def test_each_is_near_the_number_it_stands_for_and_the_interpreters(
    form: str, kernel: Any, interpreted: Any, exact: Any, values: Any
) -> None:
    """1.03 units in the last place are what all float32s showed, in C with the same operations."""
    given = values(100_000, 1)
    found = computed(kernel, form, given)
    expected = exact(given.astype(float))
    is_normal = np.abs(expected) >= LEAST
    error = np.abs(found - expected) / np.abs(np.spacing(expected.astype(F)))
    assert error[is_normal].max() < 1.04
    assert (found[~is_normal] == 0).all()
    some = np.random.default_rng(2).choice(len(given), 3000, replace=False)
    some = np.concatenate([some, np.arange(len(given) - 300, len(given))])
    np.testing.assert_array_equal(bits(found[some]), bits([interpreted(x) for x in given[some]]))


@pytest.mark.parametrize("kernel", [exponential, logarithm], ids=["exp", "log"])
def test_each_rises_from_float32_to_float32(kernel: Any) -> None:
    """On some hundred stretches of neighbours; all float32s were gone through in C."""
    random = np.random.default_rng(3)
    starts = positive(100, 4)
    starts = starts[(starts < 80) & (starts > 1e-30)]
    stretches = (bits(starts)[:, None] + np.arange(2000, dtype=np.uint32)).view(F)
    if kernel is exponential:
        signs = random.choice([-1, 1], (len(starts), 1)).astype(F)
        stretches = np.sort(stretches * signs, axis=1)
    found = computed(kernel, "cpu", stretches)
    assert (np.diff(found, axis=1) >= 0).all()


def test_powers_are_products_from_the_left() -> None:
    base = np.random.default_rng(6).uniform(-2, 2, 1000).astype(F)
    product = base
    for exponent in range(1, 6):
        np.testing.assert_array_equal(
            bits(jax.jit(powered, static_argnums=1)(base, exponent)), bits(product)
        )
        product = product * base
    assert (np.asarray(powered(base, 0)) == 1).all()
    whole = np.arange(-9, 10, dtype=np.int32)
    assert np.asarray(powered(whole, 3)).tolist() == (whole**3).tolist()

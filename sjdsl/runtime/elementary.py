"""Roots, powers, exponentials and logarithms: the operations of docs/semantics.md, section 4, one by one.

No function of XLA is called for exponentials and logarithms: those of processors and of GPUs
differ. `exactly` keeps XLA from joining a product with the sum that it feeds.
"""

import jax.numpy as jnp
from jax import Array

from sjdsl.runtime.exact_reals import (
    BIAS,
    FRACTION,
    SPECIAL,
    as_bits,
    as_real,
    assembled,
    divided,
    exactly,
    exponent_of,
    significand_of,
)
from sjdsl.runtime.forms import by_platform

LEAST = 2.0**-126  # the least positive float32 that isn't kept as 0
# ln 2 as a sum. 9 bits are enough for the first part, so its products with exponents are exact.
# Source: Cephes, expf.c and logf.c.
LN_2_HIGH = 0.693359375
LN_2_LOW = -2.12194440e-4
PER_LN_2 = 1.44269504  # 1 / ln 2
# 1 / k! for k = 7 .. 2: the series of e^r after 1 + r.
OF_EXPONENTIAL = (1 / 5040, 1 / 720, 1 / 120, 1 / 24, 1 / 6, 1 / 2)
# 2 / (2k + 1) for k = 4 .. 1: the series of ln((1 + s) / (1 - s)) after 2 s. Source: fdlibm, e_logf.c.
OF_LOGARITHM = (2 / 9, 2 / 7, 2 / 5, 2 / 3)
HALF_ROOT = 0x3504F3  # the fraction bits of the square root of 2
ROOT_BITS = 25  # of the root of a significand, with one more for rounding


def root(value: Array | float) -> Array:
    """Returns square roots, float32, of any shape; 0 for what rounding has brought below 0."""
    return jnp.sqrt(jnp.maximum(jnp.asarray(value, jnp.float32), 0))


def exact_root(value: Array | float) -> Array:
    """Returns what `root` does, correctly rounded."""
    return by_platform(_root_on_cpu, _root_on_gpu, jnp.asarray(value, jnp.float32))


def exponential(value: Array | float) -> Array:
    """Returns e to the power of reals, float32, of any shape.

    x is `exponent * ln 2 + rest`, so e^x is 2^exponent * e^rest, with e^rest from a series.

    Args:
      value: at most 88, as the compiler has proved.
    """
    x = jnp.clip(jnp.asarray(value, jnp.float32), -104, 88.5)
    exponent = jnp.rint(exactly(x * jnp.float32(PER_LN_2)))
    rest = x - exponent * jnp.float32(LN_2_HIGH)
    rest = rest - exactly(exponent * jnp.float32(LN_2_LOW))
    series = _polynomial(OF_EXPONENTIAL, rest)
    power = (exactly(rest * rest * series) + rest) + 1
    # 2^exponent is added to the exponent of the float32 that e^rest is.
    bits = as_bits(power)
    return assembled(
        jnp.zeros_like(power, bool),
        exponent_of(bits) + exponent.astype(jnp.int32),
        significand_of(bits),
    )


def logarithm(value: Array | float) -> Array:
    """Returns natural logarithms of positive reals, float32, of any shape.

    A real is `m * 2^exponent` with m between the roots of 1/2 and 2, so its logarithm is
    `exponent * ln 2 + ln m`. With f = m - 1 and s = f / (f + 2), ln m is f - f^2/2 + s (f^2/2 + R),
    where R is a series in s^2. Source: fdlibm, e_logf.c.

    What rounding has brought below 2^-126 counts as that.
    """
    bits = as_bits(jnp.maximum(jnp.asarray(value, jnp.float32), LEAST))
    # The significand is 1 .. 2; if it is above the root of 2, m is half of it.
    fraction = bits & (2**FRACTION - 1)
    is_halved = (fraction > HALF_ROOT).astype(jnp.int32)
    exponent = (exponent_of(bits) - BIAS + is_halved).astype(jnp.float32)
    exponent_bits = (BIAS - is_halved).astype(jnp.uint32) << FRACTION
    f = as_real(fraction | exponent_bits) - 1
    half_square = exactly(f * f * 0.5)
    s = divided(f, f + 2)
    s_square = s * s
    series = exactly(_polynomial(OF_LOGARITHM, s_square) * s_square)
    correction = exactly(s * (half_square + series)) - half_square
    correction = correction + exactly(exponent * jnp.float32(LN_2_LOW))
    result: Array = (f + correction) + exponent * jnp.float32(LN_2_HIGH)
    return result


def powered(base: Array | float, exponent: float) -> Array:
    """Returns base * base * … * base, multiplied from the left.

    Args:
      base: any shape, float32 or int32; a Python float counts as float32.
      exponent: how many times, a whole number from 0.
    """
    dtype = jnp.float32 if isinstance(base, float) else None
    factor = jnp.asarray(base, dtype)
    if exponent == 0:
        return jnp.ones_like(factor)
    result = factor
    for _ in range(int(exponent) - 1):
        result = result * factor
    return result


def _polynomial(coefficients: tuple[float, ...], x: Array) -> Array:
    """Returns the value of a polynomial by Horner's rule, the highest power first."""
    first, *others = coefficients
    result = jnp.full_like(x, first)
    for coefficient in others:
        result = exactly(result * x) + jnp.float32(coefficient)
    return result


def _root_on_cpu(value: Array) -> Array:
    return exactly(root(value))


def _root_on_gpu(value: Array) -> Array:
    """Takes the root of the significand bit by bit; the last bit rounds.

    A GPU's own roots are off by up to two units in the last place. Source: fdlibm, e_sqrtf.c.
    """
    bits = as_bits(value)
    exponent = exponent_of(bits) - BIAS
    rest = significand_of(bits) << (exponent & 1).astype(jnp.uint32)
    rest = rest << 1
    root_bits = jnp.zeros_like(rest)
    twice = jnp.zeros_like(rest)  # the root so far, in the place that is compared with the rest
    for place in reversed(range(ROOT_BITS)):
        bit = jnp.uint32(1 << place)
        is_in = twice + bit <= rest
        rest = jnp.where(is_in, rest - (twice + bit), rest) << 1
        twice = jnp.where(is_in, twice + 2 * bit, twice)
        root_bits = jnp.where(is_in, root_bits | bit, root_bits)
    # never halfway: a root with 25 bits has a square of 49
    rounded_up = (root_bits >> 1) + (root_bits & 1)
    result = assembled(jnp.zeros_like(value, bool), (exponent >> 1) + BIAS, rounded_up)
    result = jnp.where(exponent_of(bits) == SPECIAL, value, result)
    return jnp.where(value < LEAST, jnp.float32(0), result)

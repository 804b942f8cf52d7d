"""Arithmetic of reals that decide something: each operation rounds once, to the nearest float32.

The rule is in docs/semantics.md, section 4. XLA computes other reals differently from how they are
written: it contracts a product and a sum to one operation, multiplies by the inverse of a constant
divisor, adds and multiplies constants first, sums in any order, and on GPUs divides with an error
of up to two units in the last place. It does so across phases, and differently for a param that is
a constant of the program and for one that is an argument.
"""

import jax.numpy as jnp
from jax import Array, lax

from sjdsl.runtime.forms import by_platform, one_function
from sjdsl.runtime.reductions import sum_of
from sjdsl.runtime.rows import numbers_on_last_axis

FRACTION = 23  # bits of a float32 after its first
BIAS = 127
SPECIAL = 255  # exponent of infinity
INFINITE = SPECIAL << FRACTION
DIGIT = 12  # bits of a digit of a fixed-point number
# Digits from the last bit of the least normal float32 to those of infinity, with room for sums.
DIGITS = 28
ABOVE = 288  # place of the bits of infinity, which finite terms can't cancel


def exactly(value: Array) -> Array:
    """Returns a real unchanged; XLA can't merge its use with the operation that has computed it.

    It adds a 0 of `_zero`, which XLA can't know to be 0, to the bits.

    Args:
      value: any shape, float32.
    """
    return as_real(as_bits(value) + _zero(value))


def divided(dividend: Array | float, divisor: Array | float) -> Array:
    """Returns the quotient of two reals, float32, correctly rounded if all three are normal."""
    top = jnp.asarray(dividend, jnp.float32)
    bottom = jnp.asarray(divisor, jnp.float32)
    return by_platform(_divided_on_cpu, _divided_on_gpu, top, bottom)


def exact_ramp(value: Array, zero_at: Array, one_at: Array) -> Array:
    """Returns (value - zero_at) / (one_at - zero_at), clipped to 0 .. 1, rounded as written."""
    return jnp.clip(divided(value - zero_at, one_at - zero_at), 0.0, 1.0)


def exact_mix(row: Array) -> Array:
    """Returns the shares of a row's entries, as `rows.mix` does, each correctly rounded."""
    total = sum_of(row, axis=-1)[..., None].astype(jnp.float32)
    return exactly(divided(row.astype(jnp.float32), jnp.where(total > 0, total, 1)))


def sum_in_order(terms: Array, axis: int) -> Array:
    """Returns the sum of reals along an axis, float32, added in order, each addition rounded."""
    first, *others = jnp.moveaxis(terms, axis, 0)
    total: Array = exactly(first)
    for term in others:
        total = exactly(total + exactly(term))
    return total


def exact_sum(values: Array, axis: int | tuple[int, ...]) -> Array:
    """Returns the exact sum of reals along axes, rounded once.

    Args:
      values: float32, at most 2^19 along the axes.
      axis: the axes, counted from the first.
    """
    return rounded(sum_of(fixed_point(values), axis=axis))


@one_function
def fixed_point(values: Array) -> Array:
    """Returns reals as fixed-point numbers: `[...]` float32 -> `[..., 28]` int32.

    Their sums are exact in any order. A number is its digits in base 2^12, each with the sign of
    the number, the least significant first. Up to 2^19 numbers may be added, digit by digit.
    Numbers nearer to 0 than 2^-126 are 0.
    """
    bits = as_bits(values)[..., None]
    exponent = exponent_of(bits)
    significand = jnp.where(exponent == 0, jnp.uint32(0), significand_of(bits))
    place = jnp.where(exponent == SPECIAL, ABOVE, exponent - 1)
    shift = place - DIGIT * numbers_on_last_axis(DIGITS, values.ndim + 1)
    # Each digit is the part of the significand that lies at its place.
    left = significand << jnp.clip(shift, 0, 31).astype(jnp.uint32)
    right = significand >> jnp.clip(-shift, 0, 31).astype(jnp.uint32)
    shifted = jnp.where(shift >= 0, left, right)
    entries = (shifted & (2**DIGIT - 1)).astype(jnp.int32)
    return jnp.where(bits >> 31 == 1, -entries, entries)


@one_function
def rounded(sums: Array) -> Array:
    """Returns the nearest float32 of fixed-point sums, of two the even: `[..., 28]` -> `[...]`."""
    _, carry = _carried(sums)
    negative = carry < 0
    digits, _ = _carried(jnp.where(negative[..., None], -sums, sums))
    number = numbers_on_last_axis(DIGITS, digits.ndim)
    top = jnp.max(jnp.where(digits > 0, number, 0), axis=-1)

    def digit_below_top(places: int) -> Array:
        is_place = number == top[..., None] - places
        return jnp.sum(jnp.where(is_place, digits, 0), axis=-1, dtype=jnp.int32)

    first = digit_below_top(0)
    second = digit_below_top(1)
    third = digit_below_top(2)
    below = jnp.any((number < top[..., None] - 2) & (digits > 0), axis=-1)
    high = first << DIGIT | second
    length = exponent_of(as_bits(high.astype(jnp.float32))) - (BIAS - 1)
    # Bits of the third digit in the significand.
    more = jnp.clip(FRACTION + 1 - length, 0, DIGIT - 1)
    significand = high << more | third >> (DIGIT - more)
    rest = third & ((1 << (DIGIT - more)) - 1)
    half = 1 << (DIGIT - 1 - more)
    is_odd = (significand & 1) == 1
    up = (rest > half) | ((rest == half) & (below | is_odd))
    exponent = DIGIT * (top - 1) - more + 1
    significand = significand.astype(jnp.uint32) + up.astype(jnp.uint32)
    return assembled(negative, exponent, significand)


def _carried(sums: Array) -> tuple[Array, Array]:
    """Returns digits of 0 .. 2^12 - 1, and the carry beyond the last: negative if the number is."""
    carry = jnp.zeros_like(sums[..., 0])
    digits = []
    for place in range(DIGITS):
        carried = sums[..., place] + carry
        digits.append(carried & (2**DIGIT - 1))
        carry = carried >> DIGIT
    return jnp.stack(digits, axis=-1), carry


def _divided_on_cpu(dividend: Array, divisor: Array) -> Array:
    # XLA would multiply by the inverse of a constant divisor.
    not_constant = as_real(as_bits(divisor) + _zero(dividend))
    return dividend / not_constant


def _divided_on_gpu(dividend: Array, divisor: Array) -> Array:
    """Divides significands as whole numbers: the first bit, then 8 at a time; the last rounds.

    Numbers nearer to 0 than 2^-126 are 0.
    """
    top = as_bits(dividend)
    bottom = as_bits(divisor)
    above = significand_of(top)
    below = significand_of(bottom)
    smaller = above < below
    rest = (above << smaller.astype(jnp.uint32)) - below
    quotient = jnp.ones_like(rest)
    for _ in range(3):
        rest = rest << 8
        more = rest // below
        quotient = quotient << 8 | more
        rest = rest - more * below  # `%` would be ten operations
    significand = quotient >> 1
    is_odd = (significand & 1) == 1
    up = ((quotient & 1) == 1) & ((rest > 0) | is_odd)
    to_zero = (exponent_of(top) == 0) | (exponent_of(bottom) == SPECIAL)
    to_infinity = (exponent_of(top) == SPECIAL) | (exponent_of(bottom) == 0)
    exponent = exponent_of(top) - exponent_of(bottom) + BIAS - smaller.astype(jnp.int32)
    exponent = jnp.where(to_zero, 0, jnp.where(to_infinity, SPECIAL, exponent))
    negative = (top ^ bottom) >> 31 == 1
    result = assembled(negative, exponent, significand + up.astype(jnp.uint32))
    is_none = (to_zero & to_infinity) | (dividend != dividend) | (divisor != divisor)
    return jnp.where(is_none, jnp.float32(jnp.nan), result)


def assembled(negative: Array, exponent: Array, significand: Array) -> Array:
    """Returns float32 numbers; too small ones are 0, too large ones infinity.

    Args:
      significand: 2^23 .. 2^24, where 2^24 counts as the next exponent.
    """
    bits = ((exponent - 1).astype(jnp.uint32) << FRACTION) + significand
    is_zero = exponent <= 0
    is_infinite = exponent >= SPECIAL
    size = jnp.where(is_zero, jnp.uint32(0), jnp.where(is_infinite, jnp.uint32(INFINITE), bits))
    sign = negative.astype(jnp.uint32) << 31
    return as_real(size | sign)


def _zero(value: Array) -> Array:
    """Returns zeros, uint32, of the shape of an array, as computed values.

    No square has the remainder 2 modulo 5, which compilers don't know.
    """
    part = as_bits(value) & 0x7FFF
    square = part * part
    remainder = square - square // jnp.uint32(5) * 5
    result: Array = (remainder == 2).astype(jnp.uint32)
    return result


def exponent_of(bits: Array) -> Array:
    return (bits >> FRACTION & SPECIAL).astype(jnp.int32)


def significand_of(bits: Array) -> Array:
    result: Array = bits & (2**FRACTION - 1) | 2**FRACTION
    return result


def as_bits(value: Array) -> Array:
    return lax.bitcast_convert_type(value, jnp.uint32)


def as_real(bits: Array) -> Array:
    return lax.bitcast_convert_type(bits, jnp.float32)

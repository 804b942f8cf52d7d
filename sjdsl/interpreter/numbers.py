"""Arithmetic of the language.

32-bit integers, float32 reals, and tables computed entry by entry.
"""

import math
import operator
import struct
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from sjdsl.compiler import ir

_COMPARISONS: dict[str, Callable[[Any, Any], bool]] = {
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "==": operator.eq,
    "!=": operator.ne,
}


LEAST = 2.0**-126  # the least positive real: a smaller one counts as 0
ROOT_OF_HALF = float(np.float32(math.sqrt(0.5)))


def real(value: Any) -> Any:
    """Returns a number, or every entry of nested tuples, as float32."""
    if isinstance(value, tuple):
        return tuple(real(entry) for entry in value)
    return np.float32(0) if abs(value) < LEAST else np.float32(value)


def entrywise(fn: Callable[..., Any], *values: Any) -> Any:
    """Returns `fn` of the values, entry by entry if there are tuples.

    A number counts for every entry.
    """
    lengths = {len(value) for value in values if isinstance(value, tuple)}
    if not lengths:
        return fn(*values)
    assert len(lengths) == 1, "rows of different lengths"
    (length,) = lengths
    columns = [value if isinstance(value, tuple) else (value,) * length for value in values]
    return tuple(entrywise(fn, *entries) for entries in zip(*columns, strict=True))


def arithmetic(fn: str, values: list[Any], is_real: bool) -> Any:
    """Returns `fn` of the values, which are converted to float32 first if the result is a real."""
    return entrywise(_OPERATIONS[fn], *([real(v) for v in values] if is_real else values))


def _quotient(dividend: np.float32, divisor: np.float32) -> np.float32:
    assert divisor != 0, "division by 0"
    return np.float32(dividend / divisor)


def compare(fn: str, left: Any, right: Any) -> bool:
    """Returns whether the comparison holds; an integer beside a real is a float32."""
    if isinstance(left, np.float32) or isinstance(right, np.float32):
        left = np.float32(left)
        right = np.float32(right)
    return bool(_COMPARISONS[fn](left, right))


def total(values: list[Any], is_real: bool) -> Any:
    """Returns the sum: of reals as `added_up`, of integers exactly, of tuples entry by entry."""
    if any(isinstance(value, tuple) for value in values):
        return tuple(total(list(entries), is_real) for entries in zip(*values, strict=True))
    return added_up(values) if is_real else sum(values)


def added_up(values: Iterable[Any]) -> np.float32:
    """Returns the sum of reals, each a float32: exact, then rounded once."""
    terms = [float(np.float32(value)) for value in values]
    try:
        total = math.fsum(terms)
        remainder = math.fsum((*terms, -total))
    except ValueError:  # infinities of both signs, outside `watched`
        return np.float32(np.nan)
    # A rounded total becomes odd: then rounding it to float32 gives the same as rounding once.
    if remainder and not _is_odd(total):
        total = math.nextafter(total, math.copysign(math.inf, remainder))
    return np.float32(total)


def _is_odd(number: float) -> bool:
    """Returns whether the last bit of a float64 is 1."""
    (bits,) = struct.unpack("<Q", struct.pack("<d", number))
    return bool(bits & 1)


def shares(row: tuple[Any, ...]) -> tuple[np.float32, ...]:
    """Returns the share of each count in their sum."""
    total = np.float32(sum(row))
    assert total > 0, "shares of an empty row"
    return tuple(np.float32(np.float32(entry) / total) for entry in row)


def ramp(value: Any, zero_at: Any, one_at: Any) -> np.float32:
    """Returns (value - zero_at) / (one_at - zero_at), clipped to 0 .. 1."""
    zero = np.float32(zero_at)
    height = _quotient(np.float32(value) - zero, np.float32(one_at) - zero)
    return min(max(height, np.float32(0)), np.float32(1))


def root(value: np.float32) -> np.float32:
    """Returns the square root; 0 of what rounding has brought below 0."""
    return np.float32(math.sqrt(max(float(value), 0.0)))


def exponential(value: np.float32) -> np.float32:
    """Returns e to the power of a number, by the operations of docs/semantics.md, section 4."""
    if value < -104:
        return np.float32(0)
    number = int(np.rint(value * np.float32(1.44269504)))
    r = value - number * np.float32(0.693359375)
    r = r - number * np.float32(-2.12194440e-4)
    p = np.float32(1 / 5040)
    for factorial in (720, 120, 24, 6, 2):
        p = p * r + np.float32(1 / factorial)
    power = (r * r * p + r) + np.float32(1)
    result: np.float32 = real(math.ldexp(float(power), number))
    return result


def logarithm(value: np.float32) -> np.float32:
    """Returns the natural logarithm, by the operations of docs/semantics.md, section 4."""
    significand, number = math.frexp(max(float(value), LEAST))
    if significand <= ROOT_OF_HALF:
        significand *= 2
        number -= 1
    g = np.float32(significand - 1)
    half = np.float32(0.5) * (g * g)
    s = g / (np.float32(2) + g)
    z = s * s
    p = np.float32(2 / 9)
    for odd in (7, 5, 3):
        p = p * z + np.float32(2 / odd)
    less = (s * (half + p * z) - half) + number * np.float32(-2.12194440e-4)
    return np.float32((g + less) + number * np.float32(0.693359375))


def power(base: Any, exponent: Any) -> Any:
    """Returns a product of equal factors, multiplied from the left."""
    result = base**0
    for _ in range(int(exponent)):
        result = result * base
    return result


# All return a real for reals, but `round` returns an int.
_OPERATIONS: dict[str, Callable[..., Any]] = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": _quotient,
    "quotient": operator.floordiv,
    "%": operator.mod,
    "neg": operator.neg,
    "round": lambda x: round(float(np.float32(x))),
    "min": min,
    "max": max,
    "ramp": ramp,
    "abs": abs,
    "sqrt": root,
    "exp": exponential,
    "log": logarithm,
    "^": power,
}


def check_int32(value: int, source: object) -> None:
    """Asserts that a whole number fits into int32, as the compiler proved.

    `source`: for the message.
    """
    assert isinstance(value, int), (value, source)
    assert -(2**31) <= value < 2**31, (value, source)


def check_interval(value: Any, type_: ir.Type, source: object) -> None:
    """Asserts that a number lies in the interval that the compiler proved for it.

    Reals up to rounding.
    """
    if isinstance(value, tuple):
        for entry in value:
            check_interval(entry, type_, source)
    elif type_.kind == "int":
        check_int32(value, source)
        assert type_.low <= value <= type_.high, (value, type_, source)
    else:
        slack = 1e-5 * max(1.0, abs(float(value)))
        assert type_.low - slack <= value <= type_.high + slack, (value, type_, source)

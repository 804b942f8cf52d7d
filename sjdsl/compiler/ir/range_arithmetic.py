"""Ranges of numbers as they are computed, in int32 and float32.

The interval of a type is that of exact numbers. Here every real is rounded: `pot * 0.05` for a pot
of 9 is a little more than 0.45. One operation on numbers that are given rounds to the nearest
float32, and so do the ends of its interval. Where a result is rounded again, XLA may do it in
another order or once instead of twice, and each end is moved outward by `SLACK`. A real that leaves
float32 is infinite, and what is computed from infinity may be NaN.
"""

import struct
from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf

from sjdsl.compiler.ir.node import Type

INT32 = (-(2.0**31), 2.0**31 - 1)
WHOLE = 2.0**24  # up to here every whole number is a float32
FLOAT32 = (2 - 2.0**-23) * 2.0**127  # the largest
SMALLEST = 2.0**-126  # what is smaller may be taken for 0
SLACK = 2.0**-20  # of a result that is rounded more than once, relative; one rounding: 2^-24


@dataclass(frozen=True)
class Range:
    """All that a number can be, from `low` to `high`, which may be infinite.

    whole: it is an int32; else a float32.
    terms: the largest absolute value of the terms that it is a sum of: of `a - b`, the larger of
      the two. Rounding errors are relative to it.
    steady: its terms don't cancel each other, so that errors are relative to the number itself.
    rounded_once: it is stored, written, whole, or the result of one rounding.
    sound: it is a number; False if it may be NaN.
    literal: it is computed from written numbers alone, perhaps before they are rounded to float32.
    """

    low: float
    high: float
    whole: bool = False
    terms: float = 0.0
    steady: bool = True
    rounded_once: bool = True
    sound: bool = True
    literal: bool = False

    @property
    def largest(self) -> float:
        return max(abs(self.low), abs(self.high))


def to_float32(r: Range) -> Range:
    """Returns the range of a number once it is made a real."""
    if not r.whole:
        return r
    low, high = ends(r.low, r.high)
    return Range(low, high, terms=max(abs(low), abs(high)), sound=r.sound, literal=r.literal)


def ends(low: float, high: float) -> tuple[float, float]:
    """Returns an interval of float32.

    Numbers that are too large are infinite, those that are too small may be taken for 0.
    """
    low = nearest(low)
    high = nearest(high)
    if abs(low) < SMALLEST:
        low = -SMALLEST if low < 0 else 0.0
    if abs(high) < SMALLEST:
        high = SMALLEST if high > 0 else 0.0
    return low, high


def nearest(x: float) -> float:
    """Returns the nearest float32, infinity for a number that is too large."""
    try:
        rounded: float = struct.unpack("f", struct.pack("f", x))[0]
    except OverflowError:
        return inf if x > 0 else -inf
    return rounded


def any_number(whole: bool) -> Range:
    """Returns the range of a number of which nothing is known."""
    if whole:
        return Range(*INT32, whole=True, terms=-INT32[0])
    return Range(-inf, inf, terms=inf, sound=False)


def range_of_type(type_: Type) -> Range:
    """Returns the range of a number that is stored or written, so that nothing is rounded in it.

    A counter without a limit goes as far as int32.
    """
    if type_.kind == "real":
        exact = Range(type_.low, type_.high, whole=True)  # so that `to_float32` rounds its ends
        return to_float32(exact)
    low = max(INT32[0], type_.low)
    high = min(INT32[1], type_.high)
    return Range(low, high, whole=True, terms=max(abs(low), abs(high)))


def whole_range(low: float, high: float, *parts: Range) -> Range:
    """Returns the range of a whole number.

    One that can leave int32 can be anything there, as it wraps.
    """
    if low < INT32[0] or high > INT32[1]:
        return any_number(True)
    return Range(
        low,
        high,
        whole=True,
        terms=max(abs(low), abs(high)),
        literal=all(part.literal for part in parts),
        sound=all(part.sound for part in parts),
    )


def rounded(r: Range, times: float = 1) -> Range:
    """Returns the range of a real after so many more roundings.

    An end beyond float32 becomes infinite.
    """
    # What errors are relative to: where terms have cancelled, these, not the small result.
    size_of_low = abs(r.low) if r.steady else r.terms
    size_of_high = abs(r.high) if r.steady else r.terms
    slack = times * SLACK
    low, high = ends(r.low - slack * size_of_low, r.high + slack * size_of_high)
    return replace(r, low=low, high=high, rounded_once=False)


def is_finite(r: Range) -> bool:
    """Returns whether a number stays in float32, unless it is NaN."""
    return r.largest <= FLOAT32


def as_compared(ranges: Sequence[Range]) -> list[Range]:
    """Returns the ranges of numbers that are compared: as reals if one of them is one."""
    if all(r.whole for r in ranges):
        return list(ranges)
    reals = [to_float32(r) for r in ranges]
    if all(r.literal for r in reals):
        return [rounded(r) for r in reals]
    return reals


def differ_as_reals(a: Range, b: Range) -> bool:
    """Returns whether two numbers that a comparison tells apart differ as float32.

    Whole numbers beyond 2^24 may be rounded to one.
    """
    return not (a.whole and b.whole) or max(a.largest, b.largest) <= WHOLE


def disjoint(a: Range, b: Range) -> bool:
    """Returns whether two numbers are never equal as float32."""
    left, right = map(to_float32, as_compared((a, b)))
    return left.high < right.low or right.high < left.low

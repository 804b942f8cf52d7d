"""Ranges of numbers as they are computed, in int32 and float32, whatever the state and the parameters are.

The interval of a type is that of exact numbers. Here every real is rounded: `pot * 0.05` for a pot of 9 is a little more than 0.45.
One operation on numbers that are given rounds to the nearest float32, and so do the ends of its interval. Where a result is rounded
again, XLA may do it in another order or once instead of twice, and each end is moved outward by `SLACK`.
"""

import struct
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import reduce
from math import inf

from sjdsl.compiler import ir
from sjdsl.compiler.ir.types import interval, without_zero

INT32 = (-(2.0**31), 2.0**31 - 1)
FLOAT32 = (2 - 2.0**-23) * 2.0**127  # the largest
SMALLEST = 2.0**-126  # what is smaller may be taken for 0
SLACK = 2.0**-20  # of a result that is rounded more than once, relative; one rounding: 2^-24


@dataclass(frozen=True)
class Range:
    """All that a number can be: `low` .. `high`.

    terms: the largest absolute value of what it is a sum of, to which rounding errors are relative. steady: it is no difference of
    such terms, so that they are relative to itself. given: a number that is given, or a whole one: no more than one rounding in it.
    sound: it is a number; False if it could be infinity minus infinity and the like. literal: it is computed from written numbers alone,
    perhaps before they are rounded to float32.
    """

    low: float
    high: float
    whole: bool = False
    terms: float = 0.0
    steady: bool = True
    given: bool = True
    sound: bool = True
    literal: bool = False

    @property
    def largest(self) -> float:
        return max(abs(self.low), abs(self.high))


def range_of(e: ir.Expr) -> Range:
    """Returns what a number, or an entry of a row of numbers, can be. What is not known here can be anything."""
    match e:
        case ir.Number():
            return replace(_given(ir.Type(kind=e.type.kind, low=e.value, high=e.value)), literal=True)
        case ir.Count(domain=ir.Domain(var=ir.Member(who="cell"), restriction=None, where=None)):
            return _given(e.type.model_copy(update={"low": e.type.high}))
        case ir.Named() | ir.Narrowed() | ir.Before():
            return range_of(e.value)
        case ir.At() if e.key.type.kind == "mix":
            return _rounded(real(range_of(e.row)), len(e.key.type.words))
        case ir.At():
            return range_of(e.row)
        case ir.Arithmetic():
            return _arithmetic(e)
        case ir.SumRow(fn="sum"):
            entry, many = range_of(e.row), len(e.row.type.by[0])
            return _sum(entry, many, many)
        case ir.SumRow():
            return range_of(e.row)
        case ir.Sum():
            return _sum(range_of(e.value), 0, _most(e))
        case ir.ShiftRow():
            return _one_of((range_of(e.row), range_of(e.filler)), e.type)
        case ir.Extreme():
            return _one_of([range_of(part) for part in (e.value, e.otherwise) if part is not None], e.type)
        case ir.Case():
            return _one_of([range_of(arm.value) for arm in e.arms], e.type)
        case ir.Ramp():
            value, zero, one = (real(range_of(part)) for part in (e.value, e.zero_at, e.one_at))
            differ = apart(e.zero_at, e.one_at) or (zero.steady and one.steady)  # as a guard or a `require` says, to a part in a million
            sound = value.sound and zero.sound and one.sound and differ and zero.largest + one.largest <= FLOAT32
            return Range(0.0, 1.0, terms=1.0, given=False, sound=sound)
        case (
            ir.ParamRef()
            | ir.FieldRead()
            | ir.Attribute()
            | ir.Distance()
            | ir.Step()
            | ir.Count()
            | ir.Lowest()
            | ir.Local()
            | ir.ArgumentOf()
        ):
            return _given(e.type)
        case _:
            return _anything(e.type.kind == "int")


def real(r: Range) -> Range:
    """Returns a number as float32."""
    if not r.whole:
        return r
    low, high = _ends(r.low, r.high)
    return Range(low, high, terms=max(abs(low), abs(high)), sound=r.sound, literal=r.literal)


def compared(*numbers: ir.Expr) -> list[Range]:
    """Returns the ranges of numbers that are compared: as reals if one of them is one."""
    ranges = [range_of(e) for e in numbers]
    if all(r.whole for r in ranges):
        return ranges
    ranges = [real(r) for r in ranges]
    return [_rounded(r) for r in ranges] if all(r.literal for r in ranges) else ranges


def apart(a: ir.Expr, b: ir.Expr) -> bool:
    """Returns whether two numbers are never equal, by their ranges."""
    left, right = (real(r) for r in compared(a, b))
    return left.sound and right.sound and (left.high < right.low or right.high < left.low)


def _ends(low: float, high: float) -> tuple[float, float]:
    """Returns an interval of float32: numbers that are too large are infinite, those that are too small may be taken for 0."""
    low, high = nearest(low), nearest(high)
    least = 0.0 if 0 < low < SMALLEST else -SMALLEST if -SMALLEST < low < 0 else low
    return least, 0.0 if -SMALLEST < high < 0 else SMALLEST if 0 < high < SMALLEST else high


def nearest(x: float) -> float:
    """Returns the nearest float32, infinity for a number that is too large."""
    try:
        rounded: float = struct.unpack("f", struct.pack("f", x))[0]
    except OverflowError:
        return inf if x > 0 else -inf
    return rounded


def _anything(whole: bool) -> Range:
    return Range(*INT32, whole=True, terms=-INT32[0]) if whole else Range(-FLOAT32, FLOAT32, terms=FLOAT32, sound=False)


def _given(type_: ir.Type) -> Range:
    """Returns the range of a number that is no result. A counter without a limit goes as far as int32, a real as far as float32."""
    low, high = INT32 if type_.kind == "int" else (-FLOAT32, FLOAT32)
    low, high = max(low, type_.low), min(high, type_.high)
    if type_.kind == "int":
        return Range(low, high, whole=True, terms=max(abs(low), abs(high)))
    return real(Range(low, high, whole=True))


def _whole(low: float, high: float, *parts: Range) -> Range:
    """Returns the range of a whole number; one that can leave int32 can be anything there, as it wraps."""
    inside = INT32[0] <= low and high <= INT32[1]
    literal, sound = all(p.literal for p in parts), all(p.sound for p in parts)
    return Range(low, high, whole=True, terms=max(abs(low), abs(high)), literal=literal, sound=sound) if inside else _anything(True)


def _rounded(r: Range, often: float = 1) -> Range:
    """Returns a real with the slack of so many more roundings; one that can leave float32 is infinite there."""
    slack = [often * SLACK * (abs(end) if r.steady else r.terms) for end in (r.low, r.high)]
    low, high = _ends(r.low - slack[0], r.high + slack[1])
    return replace(r, low=low, high=high, given=False)


def _one_of(parts: Iterable[Range], type_: ir.Type) -> Range:
    """Returns the range of a number that is one of several, all made reals if one is."""
    parts = [part if type_.kind == "int" else real(part) for part in parts]
    return reduce(_hull, parts)


def _hull(a: Range, b: Range, low: Callable[..., float] = min, high: Callable[..., float] = max) -> Range:
    both = (a.steady and b.steady, a.given and b.given, a.sound and b.sound, a.literal and b.literal)
    return Range(low(a.low, b.low), high(a.high, b.high), a.whole, max(a.terms, b.terms), *both)


def _arithmetic(e: ir.Arithmetic) -> Range:
    parts = [range_of(a) if e.type.kind == "int" else real(range_of(a)) for a in e.args]
    fn: str = e.fn  # of a later operation nothing is known here
    match fn:
        case "min":
            return reduce(lambda a, b: _hull(a, b, min, min), parts)
        case "max":
            return reduce(lambda a, b: _hull(a, b, max, max), parts)
        case "neg" if parts[0].whole:
            return _whole(-parts[0].high, -parts[0].low, *parts)
        case "neg":
            return replace(parts[0], low=-parts[0].high, high=-parts[0].low)
        case "round" if parts[0].sound and parts[0].largest <= -INT32[0]:
            value = _rounded(parts[0]) if parts[0].literal else parts[0]
            return _whole(round(value.low), round(value.high), parts[0])
        case "/" if e.type.unit == "fraction" and all(isinstance(a, ir.Count) for a in e.args):  # of all, some
            return Range(0.0, 1.0, terms=1.0, given=False)
        case "+" | "-" | "*" | "/" | "%":
            divisor = without_zero(e.args[1].type) if fn in ("/", "%") else None
            if divisor is not None and e.args[1].type.kind == "int":
                low, high = max(parts[1].low, divisor.low), min(parts[1].high, divisor.high)
                parts[1] = replace(parts[1], low=low, high=high) if low <= high else _anything(parts[1].whole)
            return _of_whole(fn, parts[0], parts[1]) if e.type.kind == "int" else _of_reals(fn, parts[0], parts[1])
        case _:
            return _anything(e.type.kind == "int")


def _of_whole(fn: str, a: Range, b: Range) -> Range:
    if fn == "%" and b.low <= 0 <= b.high:
        return _anything(True)
    return _whole(*interval(fn, _type(a), _type(b)), a, b)


def _of_reals(fn: str, a: Range, b: Range) -> Range:
    """Returns the range of `a fn b` in float32."""
    if fn == "/" and b.low <= 0 <= b.high:
        return _anything(False)
    low, high = interval(fn, _type(a), _type(b))
    same_sign = (a.low >= 0 and b.low >= 0) or (a.high <= 0 and b.high <= 0)
    opposite = (a.low >= 0 and b.high <= 0) or (a.high <= 0 and b.low >= 0)
    least = min(abs(b.low), abs(b.high))
    terms, steady = {
        "+": (a.terms + b.terms, same_sign),
        "-": (a.terms + b.terms, opposite),
        "*": (a.terms * b.terms, True),
        "/": (a.terms / least * max(1.0, b.terms / least) if fn == "/" else 0.0, True),
    }[fn]
    finite = max(a.largest, b.largest) <= FLOAT32
    literal = a.literal and b.literal
    r = Range(low, high, terms=terms, steady=steady and a.steady and b.steady, sound=a.sound and b.sound and finite, literal=literal)
    once = a.given and b.given and fn != "/" and not literal  # XLA may multiply by 1 / b
    if not once or max(abs(low), abs(high)) > FLOAT32:
        return _rounded(r)
    low, high = _ends(low, high)
    return replace(r, low=low, high=high, given=False)


def _type(r: Range) -> ir.Type:
    return ir.Type(kind="int" if r.whole else "real", low=r.low, high=r.high)


def _sum(r: Range, least: int, most: float) -> Range:
    """Returns the range of a sum of so many numbers, in any order."""
    if most == inf:
        return _anything(r.whole)
    many = [n * end for n in (least, most) for end in (r.low, r.high) if n]
    low, high = min([*many, 0.0] if not least else many), max([*many, 0.0] if not least else many)
    if r.whole:
        return _whole(low, high, r)
    summed = Range(low, high, terms=most * r.terms, steady=r.steady and (r.low >= 0 or r.high <= 0), sound=r.sound)
    return _rounded(summed, max(1.0, most))


def _most(e: ir.Sum) -> float:
    """Returns how many numbers are added at most, as the compiler has found for the interval of the sum."""
    one, all_ = (max(abs(t.low), abs(t.high)) for t in (e.value.type, e.type))
    return inf if one in (0, inf) and all_ != 0 else all_ / one if one else 1.0

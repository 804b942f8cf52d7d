"""The range of every number of a game, whatever the state and the parameters are.

The rules are followed down to what is given.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import inf, isnan

from sjdsl.compiler import ir
from sjdsl.compiler.diagnostics.limits import MAX_VALUE
from sjdsl.compiler.ir.fold import BOUNDS, Analysis, fold
from sjdsl.compiler.ir.operations import CALCULATIONS, Calculation
from sjdsl.compiler.ir.queries import is_number_of_cells
from sjdsl.compiler.ir.range_arithmetic import (
    FLOAT32,
    Range,
    any_number,
    as_compared,
    differ_as_reals,
    disjoint,
    ends,
    is_finite,
    range_of_type,
    rounded,
    to_float32,
    whole_range,
)
from sjdsl.compiler.ir.types import has_limits, without_zero

Limits = Callable[[ir.Expr], tuple[float, float]]


def no_limits(_: ir.Expr) -> tuple[float, float]:
    """Returns that nothing is known of a number from elsewhere."""
    return -inf, inf


@dataclass(frozen=True)
class FloatRanges(Analysis[Range]):
    """Folds numbers to their ranges; what is not known can be anything.

    limits: the interval that is known of a number from elsewhere, as from a guard; not used where
    other variables are bound, or of another state.
    variables: the ranges of reals that `let` and `draw` name, where they are known.
    """

    rules = BOUNDS
    limits: Limits = no_limits
    variables: Mapping[str, Range] = field(default_factory=dict)

    def leaf(self, e: ir.Expr) -> Range:
        """Returns the range of an expression without parts that bound it."""
        match e:
            case ir.Number():
                written = ir.Type(kind=e.type.kind, low=e.value, high=e.value)
                return replace(range_of_type(written), literal=True)
            case ir.ParamRef() if e.type.kind == "real":
                low = max(e.type.low, -MAX_VALUE)
                high = min(e.type.high, MAX_VALUE)
                return range_of_type(ir.Type(kind="real", low=low, high=high))
            case ir.FieldRead() if e.type.kind == "real":
                # Without limits it may have been added to until it has left float32.
                return replace(range_of_type(e.type), sound=has_limits(e.type))
            case ir.Local() if e.type.kind == "real":
                computed = replace(range_of_type(e.type), sound=False)
                return self.variables.get(e.name, computed)
            case _ if is_number_of_cells(e):
                return range_of_type(e.type.changed(low=e.type.high))
            case ir.EventTotal():
                return any_number(e.type.kind == "int")
            case _ if e.type.kind in ("int", "real"):
                return range_of_type(e.type)
            case _:
                return any_number(False)

    def refined(self, e: ir.Expr, result: Range) -> Range:
        """Returns a range within the limits of the expression's type."""
        low, high = self.limits(e)
        if low <= result.low and result.high <= high:
            return result
        limited = replace(result, low=max(low, result.low), high=min(high, result.high))
        return replace(limited, terms=limited.largest) if result.rounded_once else limited

    def inside(self, _domain: ir.Domain) -> "FloatRanges":
        """Returns the ranges without limits, as other variables are bound there."""
        return FloatRanges(variables=self.variables)

    def before(self) -> "FloatRanges":
        """Returns the ranges without limits, as these are of another state."""
        return FloatRanges(variables=self.variables)

    def calculated(self, e: ir.Arithmetic, parts: list[Range]) -> Range:
        """Returns the range of a number that is calculated from others."""
        row = CALCULATIONS[e.fn]
        is_whole = e.type.kind == "int"
        if row.range is not None:
            return row.range(parts)
        are_counts = all(isinstance(part, ir.Count) for part in e.args)
        if row.share and e.type.unit == "fraction" and are_counts:  # of all, some
            return Range(0.0, 1.0, terms=1.0, rounded_once=False)
        parts = parts if is_whole else [to_float32(p) for p in parts]
        if row.divisor is not None:
            divisor = _not_zero(parts[row.divisor], e.args[row.divisor].type)
            parts[row.divisor] = divisor
            if divisor.low <= 0 <= divisor.high:
                return any_number(is_whole)
        low, high = row.interval(*((p.low, p.high) for p in parts))
        if is_whole:
            return (
                whole_range(low, high, *parts) if all(p.sound for p in parts) else any_number(True)
            )
        if row.rounding is not None:
            return _of_reals(row, low, high, *parts)
        exact = _unrounded(low, high, parts)
        if row.factors:
            return exact
        return replace(exact, terms=min(exact.terms, exact.largest))  # no sum any more

    def either(self, e: ir.Expr, parts: Sequence[Range]) -> Range:
        """Returns the range of a number that is one of several, all made reals if one is."""
        if e.type.kind != "int":
            parts = [to_float32(part) for part in parts]
        low = min(part.low for part in parts)
        high = max(part.high for part in parts)
        return _unrounded(low, high, parts)

    def entry(self, e: ir.At, row: Range) -> Range:
        """Returns the range of an entry of a row, or of a mean of its entries."""
        if e.key.type.kind != "mix":
            return row
        row = to_float32(row)
        return rounded(replace(row, sound=row.sound and is_finite(row)), len(e.key.type.words))

    def total(self, r: Range, least: int, most: float) -> Range:
        """Returns the range of a sum of so many numbers of a range, in any order."""
        if most == inf:
            return any_number(r.whole)
        sums: list[float] = []
        for number in (least, most):
            sums += [number * r.low, number * r.high] if number else [0.0]
        low = min(sums)
        high = max(sums)
        if r.whole:
            return whole_range(low, high, r)
        one_sign = r.low >= 0 or r.high <= 0
        sound = r.sound and (one_sign or most * r.largest <= FLOAT32)  # no infinity minus infinity
        summed = Range(low, high, terms=most * r.terms, steady=r.steady and one_sign, sound=sound)
        return rounded(summed, max(1.0, most))

    def most(self, e: ir.Sum) -> float:
        """Returns how many numbers are added at most, by the intervals in the types."""
        one = max(abs(e.value.type.low), abs(e.value.type.high))
        total = max(abs(e.type.low), abs(e.type.high))
        if one in (0, inf) and total != 0:
            return inf
        return total / one if one else 1.0


def range_of(e: ir.Expr, limits: Limits = no_limits) -> Range:
    """Returns what a number, or an entry of a row of numbers, can be.

    For `limits` see FloatRanges.
    """
    return fold(e, FloatRanges(limits))


def compared(*numbers: ir.Expr) -> list[Range]:
    """Returns the ranges of numbers that are compared: as reals if one of them is one."""
    return as_compared([range_of(e) for e in numbers])


def are_numbers(*numbers: ir.Expr) -> bool:
    """Returns whether none of some numbers can be NaN."""
    return all(e.type.kind != "real" or range_of(e).sound for e in numbers)


def stays_in_float32(e: ir.Expr, added: float = 1) -> bool:
    """Returns whether a real is neither infinite nor NaN, also if so many of it are added."""
    r = range_of(e)
    return r.sound and added * r.largest <= FLOAT32


def apart(a: ir.Expr, b: ir.Expr, known: bool = False) -> bool:
    """Returns whether two numbers are never equal as float32, by their ranges.

    `known`: a comparison tells them apart.
    """
    a_range = range_of(a)
    b_range = range_of(b)
    return disjoint(a_range, b_range) or (known and differ_as_reals(a_range, b_range))


def _unrounded(low: float, high: float, parts: Sequence[Range]) -> Range:
    """Returns the range of a number that is one of the parts or its negative: none is rounded."""
    return Range(
        low,
        high,
        parts[0].whole,
        terms=max(part.terms for part in parts),
        steady=all(part.steady for part in parts),
        rounded_once=all(part.rounded_once for part in parts),
        sound=all(part.sound for part in parts),
        literal=all(part.literal for part in parts),
    )


def _not_zero(divisor: Range, type_: ir.Type) -> Range:
    """Returns the range of a divisor, which is not 0: a whole number begins or ends beside it."""
    if type_.kind != "int":
        return divisor
    other_than_zero = without_zero(type_)
    low = max(divisor.low, other_than_zero.low)
    high = min(divisor.high, other_than_zero.high)
    return replace(divisor, low=low, high=high) if low <= high else any_number(divisor.whole)


def _of_reals(row: Calculation, low: float, high: float, a: Range, b: Range) -> Range:
    """Returns the range of what is calculated from two reals in float32.

    Args:
      low, high: the ends of its interval as an exact number.
    """
    assert row.rounding is not None
    terms, steady, once = row.rounding(a, b)
    finite = is_finite(a) and is_finite(b)
    if isnan(low) or isnan(high):  # the sum of infinite ends
        return any_number(False)
    literal = a.literal and b.literal
    r = Range(
        low,
        high,
        terms=terms,
        steady=steady and a.steady and b.steady,
        sound=a.sound and b.sound and finite,
        literal=literal,
    )
    is_rounded_once = once and a.rounded_once and b.rounded_once and not literal
    if not is_rounded_once or max(abs(low), abs(high)) > FLOAT32:
        return rounded(r)
    low, high = ends(low, high)
    return replace(r, low=low, high=high, rounded_once=False)

"""Sums and differences of numbers: what conditions about sums say of other sums of the same parts.

p + q <= 1   ->   1 - p - q is at least 0
"""

from collections.abc import Iterable, Iterator
from dataclasses import field
from fractions import Fraction
from functools import cached_property
from math import isinf

from sjdsl.compiler import ir
from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.ir.equivalence import Form, form
from sjdsl.compiler.ir.operations import CALCULATIONS

Interval = tuple[float, float]
Memo = dict[int, "Linear"]  # by the `id` of an expression, which must live as long


class Linear(Record, eq=False):
    """A number that is added to so many times each part.

    `parts`: each with its interval, by its form. All is exact.
    """

    number: Fraction = Fraction(0)
    factors: dict[Form, Fraction] = field(default_factory=dict)
    parts: dict[Form, Interval] = field(default_factory=dict)

    def plus(self, other: "Linear", factor: Fraction | int = 1) -> "Linear":
        """Returns this sum plus `factor` times another."""
        factors = dict(self.factors)
        for part, other_factor in other.factors.items():
            factors[part] = factors.get(part, Fraction(0)) + factor * other_factor
        return Linear(
            self.number + factor * other.number,
            {part: sum_ for part, sum_ in factors.items() if sum_},
            self.parts | other.parts,
        )

    @cached_property
    def interval(self) -> Interval:
        """What it can be, by the intervals of its parts."""
        low: Fraction | float = self.number
        high: Fraction | float = self.number
        for part, factor in self.factors.items():
            ends = [factor * (end if isinf(end) else Fraction(end)) for end in self.parts[part]]
            low += min(ends)
            high += max(ends)
        return float(low), float(high)


def linear(e: ir.Expr, memo: Memo | None = None) -> Linear:
    """Returns a number as a sum of parts, which are no sums themselves.

    `memo`: the sums that are known, to which this one is added.
    """
    memo = {} if memo is None else memo
    if id(e) not in memo:
        memo[id(e)] = _linear(e, memo)
    return memo[id(e)]


def _linear(e: ir.Expr, memo: Memo) -> Linear:
    """Returns `linear(e, memo)`, computed anew."""
    match e:
        case ir.Number():
            return Linear(Fraction(e.value))
        case ir.Named() | ir.Narrowed():
            return linear(e.value, memo)
        case ir.Arithmetic(fn=fn, args=args) if CALCULATIONS[fn].factors and not e.type.indexed_by:
            sum_ = Linear()
            for arg, factor in zip(args, CALCULATIONS[fn].factors, strict=True):
                sum_ = sum_.plus(linear(arg, memo), factor)
            return sum_
        case _:
            part = form(e)
            return Linear(Fraction(0), {part: Fraction(1)}, {part: (e.type.low, e.type.high)})


def narrowed_sum(mine: Linear, interval: Interval, known: Iterable[Linear]) -> Interval:
    """Returns the interval of a sum or difference, by other sums of the same parts.

    Args:
      interval: what is known without these.
      known: sums that are at least 0. They are used one at a time.
    """
    low, high = interval
    for fact in known:
        for part in mine.factors.keys() & fact.factors.keys():
            factor = mine.factors[part] / fact.factors[part]
            # The sum is this rest and `factor` times the fact, which is at least 0.
            rest_low, rest_high = mine.plus(fact, -factor).interval
            if factor > 0:
                low = max(low, rest_low)
            else:
                high = min(high, rest_high)
    return low, high


def not_negative(condition: ir.Expr) -> Iterator[Linear]:
    """Yields the sums of several parts that are at least 0 if a condition holds.

    Of a single part, its interval says as much.
    """
    match condition:
        case ir.Compare(fn=fn, left=left, right=right) if fn != "!=" and not (
            left.type.indexed_by or right.type.indexed_by
        ):
            difference = linear(left).plus(linear(right), -1)
            if len(difference.factors) < 2:
                return
            # A whole number that is above another is above it by one.
            is_whole = left.type.kind == right.type.kind == "int"
            gap = Linear(Fraction(-1)) if is_whole and fn in ("<", ">") else Linear()
            if fn in (">", ">=", "=="):
                yield difference.plus(gap)
            if fn in ("<", "<=", "=="):
                yield gap.plus(difference, -1)
        case ir.InRange(value=value, low=low, high=high):
            yield from not_negative(ir.Compare(fn=">=", left=value, right=low))
            yield from not_negative(ir.Compare(fn="<=", left=value, right=high))
        case _:
            pass

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
    """A number that is added to so many times each part; `parts`: each with its interval, by its form. All is exact."""

    number: Fraction = Fraction(0)
    factors: dict[Form, Fraction] = field(default_factory=dict)
    parts: dict[Form, Interval] = field(default_factory=dict)

    def plus(self, other: "Linear", factor: Fraction | int = 1) -> "Linear":
        """Returns the sum with the other one times a factor."""
        factors = dict(self.factors)
        for part, times_ in other.factors.items():
            factors[part] = factors.get(part, Fraction(0)) + factor * times_
        return Linear(
            self.number + factor * other.number,
            {p: f for p, f in factors.items() if f},
            self.parts | other.parts,
        )

    @cached_property
    def interval(self) -> Interval:
        """What it can be, by the intervals of its parts."""
        low: Fraction | float = self.number
        high: Fraction | float = self.number
        for part, factor in self.factors.items():
            ends = [factor * (end if isinf(end) else Fraction(end)) for end in self.parts[part]]
            low, high = low + min(ends), high + max(ends)
        return float(low), float(high)


def linear(e: ir.Expr, memo: Memo | None = None) -> Linear:
    """Returns a number as a sum of parts, which are no sums themselves. `memo`: the sums that are known, to which this one is added."""
    memo = {} if memo is None else memo
    if id(e) not in memo:
        memo[id(e)] = _linear(e, memo)
    return memo[id(e)]


def _linear(e: ir.Expr, memo: Memo) -> Linear:
    match e:
        case ir.Number():
            return Linear(Fraction(e.value))
        case ir.Named() | ir.Narrowed():
            return linear(e.value, memo)
        case ir.Arithmetic(fn=fn, args=args) if CALCULATIONS[fn].factors and not e.type.by:
            sum_ = Linear()
            for part, factor in zip(args, CALCULATIONS[fn].factors, strict=True):
                sum_ = sum_.plus(linear(part, memo), factor)
            return sum_
        case _:
            own = form(e)
            return Linear(Fraction(0), {own: Fraction(1)}, {own: (e.type.low, e.type.high)})


def narrowed_sum(mine: Linear, interval: Interval, known: Iterable[Linear]) -> Interval:
    """Returns the interval of a sum or difference once it is known what other sums of the same parts are at least 0, one at a time."""
    low, high = interval
    for fact in known:
        for part in mine.factors.keys() & fact.factors.keys():
            factor = mine.factors[part] / fact.factors[part]
            rest = mine.plus(
                fact, -factor
            ).interval  # e is this and `factor` times the fact, which is at least 0
            if factor > 0:
                low = max(low, rest[0])
            else:
                high = min(high, rest[1])
    return low, high


def not_negative(condition: ir.Expr) -> Iterator[Linear]:
    """Yields what is at least 0 if a condition holds, of sums of several parts; of fewer, their intervals say as much."""
    match condition:
        case ir.Compare(fn=fn, left=left, right=right) if fn != "!=" and not (
            left.type.by or right.type.by
        ):
            apart = linear(left).plus(linear(right), -1)
            whole = left.type.kind == right.type.kind == "int"
            if len(apart.factors) < 2:
                return
            if fn in (">", ">=", "=="):
                yield apart.plus(Linear(Fraction(-1))) if whole and fn == ">" else apart
            if fn in ("<", "<=", "=="):
                turned = Linear().plus(apart, -1)
                yield turned.plus(Linear(Fraction(-1))) if whole and fn == "<" else turned
        case ir.InRange(value=value, low=low, high=high):
            yield from not_negative(ir.Compare(fn=">=", left=value, right=low))
            yield from not_negative(ir.Compare(fn="<=", left=value, right=high))
        case _:
            pass

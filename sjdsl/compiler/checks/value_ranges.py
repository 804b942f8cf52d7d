"""Intervals of numbers in a game with given parameters, and whole numbers that can leave int32.

The interval in a type holds for all parameters that a file admits; one without limits makes it
endless. Here a parameter has its value, `step` ends with the episode, a timer is at most what it is
set to, and guards count. A whole number is looked at wherever its value is used.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from math import inf
from typing import Any, NamedTuple

from sjdsl.compiler import ir
from sjdsl.compiler.diagnostics.limits import MAX_INTEGER
from sjdsl.compiler.ir.equivalence import Form, Memo, form
from sjdsl.compiler.ir.fold import BOUNDS, Analysis, UnknownValue, fold
from sjdsl.compiler.ir.implications import conjuncts, limits_of
from sjdsl.compiler.ir.operations import CALCULATIONS, COMPARISONS
from sjdsl.compiler.ir.queries import most_members
from sjdsl.compiler.ir.types import times
from sjdsl.compiler.ir.values import Evaluation

LOWEST = -MAX_INTEGER - 1
HIGHEST = MAX_INTEGER
Interval = tuple[float, float]
Held = tuple[str, str]  # a field: what holds it, and its name


@dataclass
class Played:
    """A game with its numbers, and what is collected while its rules are gone through.

    steps: of a trial, or of the episode without trials. trials: of an episode.
    timers: the largest value of each so far. totals: the largest total of each event in an episode.
    leaving: the whole numbers that leave int32.
    sets, growth: of each timer, the largest value it is set to, and how much those statements that
      count it on (`set t = t + n`) can add in a step.
    forms: of expressions.
    """

    game: ir.Game
    params: Mapping[str, Any]
    steps: float = 0
    trials: int = 1
    timers: dict[Held, float] = field(default_factory=dict)
    totals: dict[str, float] = field(default_factory=dict)
    leaving: "list[Leaving]" = field(default_factory=list)
    sets: dict[Held, float] = field(default_factory=dict)
    growth: dict[Held, float] = field(default_factory=dict)
    forms: Memo = field(default_factory=dict)

    @property
    def steps_of_episode(self) -> float:
        return self.steps * self.trials


@dataclass(frozen=True, eq=False)
class IntRanges(Analysis[Interval]):
    """Folds numbers, and rows of numbers, to their intervals at one place of the rules.

    What leaves int32 is added to `played.leaving`. locals: the intervals of variables. known: what
    the guards around leave to expressions.
    """

    rules = BOUNDS
    played: Played
    locals: Mapping[str, Interval] = field(default_factory=dict)
    known: Mapping[Form, Interval] = field(default_factory=dict)

    def knowing(self, condition: ir.Expr, holds: bool = True) -> "IntRanges":
        """Returns this place, where a condition is known to hold, or (`holds` False) not to."""
        place = self
        num_leaving = len(self.played.leaving)
        for part in conjuncts(condition, holds):
            for subject, fn, other in _comparisons(part):
                limits = limits_of(fn, subject, interval_of(other, place))
                if limits is not None:
                    place = place.bounded(subject, limits)
        # What leaves int32 in the condition itself is collected where it is written.
        del self.played.leaving[num_leaving:]
        return place

    def with_local(self, name: str, interval: Interval) -> "IntRanges":
        """Returns this place with one more variable."""
        return replace(self, locals={**self.locals, name: interval})

    def bounded(self, e: ir.Expr, limits: Interval) -> "IntRanges":
        """Returns this place, where a number is known to lie in an interval."""
        subject = form(e, memo=self.played.forms)
        low, high = self.known.get(subject, (-inf, inf))
        bounded = (max(low, limits[0]), min(high, limits[1]))
        return replace(self, known={**self.known, subject: bounded})

    def inside(self, domain: ir.Domain) -> "IntRanges":
        """Goes through a domain, and returns the place where its variables are members of it."""
        if domain.restriction is not None:
            visit_children(domain.restriction, self)
        if domain.where is None:
            return self
        visit(domain.where, self)
        return self.knowing(domain.where)

    def in_arm(self, e: ir.Case, arm: ir.Arm) -> "IntRanges":
        """Returns what is known in an arm of a `case`."""
        if e.subject.type.kind == "condition":
            return self.knowing(e.subject, arm.words == ("yes",))
        if e.subject.type.kind == "int":
            low = -inf if arm.low is None else arm.low
            high = inf if arm.high is None else arm.high
            return self.bounded(e.subject, (low, high))
        return self

    def before(self) -> "IntRanges":
        return replace(self, known={})  # what is known is known of the state after the step

    def leaf(self, e: ir.Expr) -> Interval:
        """Returns the interval of an expression without parts that bound it."""
        match e:
            case ir.Number():
                return e.value, e.value
            case ir.ParamRef() if _is_of_numbers(e):
                return _ends(self.played.params[e.name])
            case ir.FieldRead():
                visit_children(e, self)
                return e.type.low, self.played.timers.get((e.held_by.what, e.name), inf)
            case ir.Local():
                return self.locals.get(e.name, (-inf, inf))
            case ir.Step():
                return 0, self.played.steps
            case ir.EventTotal():
                return 0, self.played.totals.get(e.name, 0)
            case ir.Logic():
                ranges = self
                for part in e.args:
                    visit(part, ranges)
                    ranges = ranges.knowing(part, e.fn == "and")
            case _:
                visit_children(e, self)
        return e.type.low, e.type.high

    def refined(self, e: ir.Expr, result: Interval) -> Interval:
        """Returns an interval within all that is known.

        Notes a whole number that can leave int32.
        """
        known = (-inf, inf)
        if self.known:
            known = self.known.get(form(e, memo=self.played.forms), known)
        low = max(result[0], e.type.low, known[0])
        high = min(result[1], e.type.high, known[1])
        if e.type.kind == "int" and low <= high and leaves_int32((low, high)):
            self.played.leaving.append(Leaving(e, (low, high), self))
            return 0, 0  # reported once: what is computed from it is not at fault
        return low, high

    def calculated(self, e: ir.Arithmetic, parts: list[Interval]) -> Interval:
        return CALCULATIONS[e.fn].interval(*parts)

    def either(self, _e: ir.Expr, parts: list[Interval]) -> Interval:
        return _hull(parts)

    def entry(self, e: ir.At, row: Interval) -> Interval:
        """Returns the interval of an entry: of a fixed one of a table its value."""
        visit(e.key, self)
        if not _is_of_numbers(e):
            return row
        try:
            return _ends(fold(e, Evaluation(self._parameter, computes_reals=False)))
        except UnknownValue:
            return row

    def _parameter(self, e: ir.Expr) -> Any:
        if not isinstance(e, ir.ParamRef):
            raise UnknownValue
        return self.played.params[e.name]

    def total(self, part: Interval, least: int, most: float) -> Interval:
        low = min(times(part[0], least), times(part[0], most))
        high = max(times(part[1], least), times(part[1], most))
        return low, high

    def most(self, e: ir.Sum) -> float:
        return most_members(e.domain, self.played.game)


class Leaving(NamedTuple):
    """A whole number that can leave int32: the interval it can be in, at a place."""

    value: ir.Expr
    interval: Interval
    ranges: IntRanges


def _comparisons(condition: ir.Expr) -> Iterator[tuple[ir.Expr, ir.Comparison, ir.Expr]]:
    """Yields what a condition says of whole numbers.

    Beside a real they are rounded, and then it says less.
    """
    comparisons: list[tuple[ir.Expr, ir.Comparison, ir.Expr]] = []
    match condition:
        case ir.Compare(fn=fn, left=left, right=right):
            comparisons = [(left, fn, right), (right, COMPARISONS[fn].mirror, left)]
        case ir.InRange(value=value, low=low, high=high):
            comparisons = [(value, ">=", low), (value, "<=", high)]
    for subject, fn, other in comparisons:
        if subject.type.kind == other.type.kind == "int":
            yield subject, fn, other


def interval_of(e: ir.Expr, ranges: IntRanges) -> Interval:
    """Returns the interval of a number, or of all entries of a row.

    What leaves int32 in it is added to `played.leaving`.
    """
    return fold(e, ranges)


def leaves_int32(interval: Interval) -> bool:
    """Returns whether some number of an interval is none of int32."""
    return not (interval[0] >= LOWEST and interval[1] <= HIGHEST)


def visit(node: ir.Node, ranges: IntRanges) -> None:
    """Goes through a part of the rules that isn't a statement."""
    if isinstance(node, ir.Domain):
        ranges.inside(node)
    elif ir.is_expression(node):
        fold(node, ranges)
    else:
        visit_children(node, ranges)


def visit_children(node: ir.Node, ranges: IntRanges) -> None:
    """Goes through all parts of a node, but not through what it is itself."""
    for child in ir.children(node):
        visit(child, ranges)


def _is_of_numbers(e: ir.Expr) -> bool:
    return e.type.kind in ("int", "real")


def _ends(value: Any) -> Interval:
    if isinstance(value, tuple):
        return _hull(_ends(entry) for entry in value)
    return value, value


def _hull(intervals: Iterable[Interval]) -> Interval:
    lows, highs = zip(*intervals, strict=True)
    return min(lows), max(highs)

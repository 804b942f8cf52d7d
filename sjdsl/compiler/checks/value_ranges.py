"""Intervals of numbers in a game with given parameters, and the whole numbers that can leave int32.

The interval in a type holds for all parameters that a file admits; one without limits makes it endless. Here a parameter has its value, `step`
ends with the episode, a timer is at most what it is set to, and guards count. A whole number is looked at wherever its value is used.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from math import inf
from typing import Any, NamedTuple

from sjdsl.compiler import ir
from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.diagnostics.limits import MAX_INTEGER
from sjdsl.compiler.ir.equivalence import Form, Memo, form
from sjdsl.compiler.ir.implications import conjuncts, limits_of
from sjdsl.compiler.ir.operations import CALCULATIONS, COMPARISONS, REDUCTIONS
from sjdsl.compiler.ir.queries import most_members
from sjdsl.compiler.ir.types import times

LOWEST, HIGHEST = -MAX_INTEGER - 1, MAX_INTEGER
Interval = tuple[float, float]
Held = tuple[str, str]  # a field: what holds it, and its name


@dataclass
class Played:
    """A game with its numbers, and what is found while its rules are gone through.

    steps: of an episode. timers: the largest value of each so far. totals: the largest total of each event in an episode.
    leaving: the whole numbers that leave int32. sets, growth: of each timer, the largest value it is set to, and how much those statements
    that count it on (`set t = t + n`) can add in a step. forms: of expressions.
    """

    game: ir.Game
    params: Mapping[str, Any]
    steps: float = 0
    timers: dict[Held, float] = field(default_factory=dict)
    totals: dict[str, float] = field(default_factory=dict)
    leaving: "list[Leaving]" = field(default_factory=list)
    sets: dict[Held, float] = field(default_factory=dict)
    growth: dict[Held, float] = field(default_factory=dict)
    forms: Memo = field(default_factory=dict)


class Here(Record, eq=False):
    """One place of the rules. known: what the guards around leave to expressions."""

    played: Played
    locals: Mapping[str, Interval] = field(default_factory=dict)
    known: Mapping[Form, Interval] = field(default_factory=dict)

    def knowing(self, condition: ir.Expr, holds: bool = True) -> "Here":
        """Returns this place, where a condition is known to hold (or, with `holds` False, not to hold)."""
        here, already = self, len(self.played.leaving)
        for part in conjuncts(condition, holds):
            for subject, fn, other in _comparisons(part):
                limits = limits_of(fn, subject, interval_of(other, here))
                here = here if limits is None else here.bounded(subject, limits)
        del self.played.leaving[
            already:
        ]  # the condition itself is gone through where it is written
        return here

    def bounded(self, e: ir.Expr, limits: Interval) -> "Here":
        """Returns this place, where a number is known to lie in an interval."""
        subject = form(e, memo=self.played.forms)
        low, high = self.known.get(subject, (-inf, inf))
        return replace(
            self, known={**self.known, subject: (max(low, limits[0]), min(high, limits[1]))}
        )


class Leaving(NamedTuple):
    """A whole number that can leave int32: the interval it can be in, at a place."""

    value: ir.Expr
    interval: Interval
    here: Here


def _comparisons(condition: ir.Expr) -> Iterator[tuple[ir.Expr, ir.Comparison, ir.Expr]]:
    """Yields what a condition says of whole numbers; beside a real they are rounded, and then it says less."""
    match condition:
        case ir.Compare(fn=fn, left=left, right=right):
            found: list[tuple[ir.Expr, ir.Comparison, ir.Expr]] = [
                (left, fn, right),
                (right, COMPARISONS[fn].mirror, left),
            ]
        case ir.InRange(value=value, low=low, high=high):
            found = [(value, ">=", low), (value, "<=", high)]
        case _:
            found = []
    yield from (
        (subject, fn, other)
        for subject, fn, other in found
        if subject.type.kind == other.type.kind == "int"
    )


def interval_of(e: ir.Expr, here: Here) -> Interval:
    """Returns the interval of a number, of a row that of all its entries; what leaves int32 in it is added to what was found."""
    low, high = _VALUES.get(type(e), _by_type)(e, here)
    guarded = (
        here.known.get(form(e, memo=here.played.forms), (-inf, inf)) if here.known else (-inf, inf)
    )
    low, high = max(low, e.type.low, guarded[0]), min(high, e.type.high, guarded[1])
    if e.type.kind == "int" and low <= high and leaves_int32((low, high)):
        here.played.leaving.append(Leaving(e, (low, high), here))
        return 0, 0  # reported once: what is computed from it is not at fault
    return low, high


def leaves_int32(interval: Interval) -> bool:
    """Returns whether some number of an interval is none of int32."""
    return not (interval[0] >= LOWEST and interval[1] <= HIGHEST)


def visit(node: ir.Node, here: Here) -> None:
    """Goes through a part of the rules that isn't a statement."""
    match node:
        case ir.Logic():
            for part in node.args:
                visit(part, here)
                here = here.knowing(part, node.fn == "and")
        case ir.Case() if node.type.kind not in ("int", "real"):
            _arms(node, here)
        case ir.Domain():
            inside(node, here)
        case _ if ir.is_expression(node) and node.type.kind in ("int", "real"):
            interval_of(node, here)
        case _:
            visit_children(node, here)


def visit_children(node: ir.Node, here: Here) -> None:
    """Goes through all parts of a node, but not through what it is itself."""
    for child in ir.children(node):
        visit(child, here)


def inside(domain: ir.Domain, here: Here) -> Here:
    """Goes through a domain, and returns the place where its variables are members of it."""
    if domain.restriction is not None:
        visit_children(domain.restriction, here)
    if domain.where is None:
        return here
    visit(domain.where, here)
    return here.knowing(domain.where)


def _by_type(e: ir.Expr, here: Here) -> Interval:
    visit_children(e, here)
    return e.type.low, e.type.high


def _field(e: ir.FieldRead, here: Here) -> Interval:
    visit_children(e, here)
    return e.type.low, here.played.timers.get((e.held_by.what, e.name), inf)


def _entry(e: ir.At, here: Here) -> Interval:
    visit(e.key, here)
    value = _known_entry(e, here.played.params)
    return interval_of(e.row, here) if value is None else _ends(value)


def _known_entry(e: ir.Expr, params: Mapping[str, Any]) -> Any:
    """Returns the value of a parameter, or of its entry under written keys; None where a key is computed."""
    match e:
        case ir.ParamRef():
            return params[e.name]
        case ir.At(row=row, key=ir.Word() | ir.Number() as key):
            table = _known_entry(row, params)
            return None if table is None else table[row.type.by[0].place_of(key.value)]  # type: ignore[arg-type]
        case _:
            return None


def _ends(value: Any) -> Interval:
    return _hull(_ends(entry) for entry in value) if isinstance(value, tuple) else (value, value)


def _hull(intervals: Iterable[Interval]) -> Interval:
    lows, highs = zip(*intervals, strict=True)
    return min(lows), max(highs)


def _sum(e: ir.Sum, here: Here) -> Interval:
    low, high = interval_of(e.value, inside(e.domain, here))
    number = most_members(e.domain, here.played.game)
    return times(min(low, 0), number), times(max(high, 0), number)


def _of_row(e: ir.SumRow, here: Here) -> Interval:
    low, high = interval_of(e.row, here)
    number = len(e.row.type.by[0]) if REDUCTIONS[e.fn].adds else 1
    return times(low, number), times(high, number)


def _extreme(e: ir.Extreme, here: Here) -> Interval:
    values = [interval_of(e.value, inside(e.domain, here))]
    return _hull(values if e.otherwise is None else [*values, interval_of(e.otherwise, here)])


def _arms(e: ir.Case, here: Here) -> list[Interval]:
    visit(e.subject, here)
    found = []
    for arm in e.arms:
        inner = here
        if e.subject.type.kind == "condition":
            inner = here.knowing(e.subject, arm.words == ("yes",))
        elif e.subject.type.kind == "int":
            inner = here.bounded(
                e.subject,
                (-inf if arm.low is None else arm.low, inf if arm.high is None else arm.high),
            )
        if e.type.kind in ("int", "real"):
            found.append(interval_of(arm.value, inner))
        else:
            visit(arm.value, inner)
    return found


# Of each class of number its interval; of all others the one in their type.
_VALUES: dict[type[ir.Node], Callable[[Any, Here], Interval]] = {
    ir.Number: lambda e, _: (e.value, e.value),
    ir.ParamRef: lambda e, here: _ends(here.played.params[e.name]),
    ir.Local: lambda e, here: here.locals.get(e.name, (-inf, inf)),
    ir.FieldRead: _field,
    ir.At: _entry,
    ir.Step: lambda _, here: (0, here.played.steps),
    ir.EventTotal: lambda e, here: (0, here.played.totals.get(e.name, 0)),
    ir.Arithmetic: lambda e, here: CALCULATIONS[e.fn].interval(
        *[interval_of(a, here) for a in e.args]
    ),
    ir.Sum: _sum,
    ir.SumRow: _of_row,
    ir.ShiftRow: lambda e, here: _hull([interval_of(e.row, here), interval_of(e.filler, here)]),
    ir.Extreme: _extreme,
    ir.Case: lambda e, here: _hull(_arms(e, here)),
    ir.Named: lambda e, here: interval_of(e.value, here),
    ir.Before: lambda e, here: interval_of(
        e.value, replace(here, known={})
    ),  # what is known is known of the state after the step
}

"""What the statements of a phase add up to: for an entry of a field, and for a count of an event.

All that is added to an entry in a phase, and all that is counted of an event in a step, is one sum.
A statement is in it as often as the quantifiers around it have members, but for the one whose
member is the target: each of these has a sum of its own.
"""

from collections.abc import Iterable
from math import inf
from typing import Literal, NamedTuple

from sjdsl.compiler import ir
from sjdsl.compiler.checks.value_ranges import (
    Interval,
    IntRanges,
    interval_of,
    visit,
    visit_children,
)
from sjdsl.compiler.ir.operations import CALCULATIONS
from sjdsl.compiler.ir.queries import declared_field, lanes_of, most_members, written_field
from sjdsl.compiler.ir.types import times


class Target(NamedTuple):
    """What is added to: a field, by what holds it and its name, or an event.

    owner: the variable whose entry it is, if it is one.
    """

    sort: Literal["field", "event"]
    held_by: str
    name: str
    owner: str = ""


class Part(NamedTuple):
    """A statement that adds, the interval of what it adds at a time, and how often it does."""

    statement: ir.Add | ir.Tally
    each: Interval
    often: float = 1

    @property
    def most(self) -> float:
        """How far it can take the sum."""
        return times(max(map(abs, self.each)), self.often)


class Sum(NamedTuple):
    """The interval of a sum, and the statement that takes it farthest."""

    low: float
    high: float
    part: Part

    @property
    def interval(self) -> Interval:
        return self.low, self.high

    def times(self, number: float) -> "Sum":
        """Returns the sum of a block that happens so often."""
        low = times(self.low, number)
        high = times(self.high, number)
        return Sum(low, high, self.part._replace(often=times(self.part.often, number)))


Sums = dict[Target, Sum]


def merged(sums_of_blocks: Iterable[Sums], all_happen: bool = True) -> Sums:
    """Returns the sums of several blocks that all happen, or of which one does.

    All sums have 0 in their interval, as statements may not happen.
    """
    total: Sums = {}
    for sums in sums_of_blocks:
        for target, sum_ in sums.items():
            if target not in total:
                total[target] = sum_
                continue
            other = total[target]
            low = other.low + sum_.low if all_happen else min(other.low, sum_.low)
            high = other.high + sum_.high if all_happen else max(other.high, sum_.high)
            part = max(other.part, sum_.part, key=lambda part: part.most)
            total[target] = Sum(low, high, part)
    return total


def sums_of(phase: ir.Phase, ranges: IntRanges) -> Sums:
    """Goes through a phase, and returns what it adds, whatever variable names the owner.

    Two variables can be one agent or cell.
    """
    sums = block(phase.body, ranges)
    return merged({target._replace(owner=""): sum_} for target, sum_ in sums.items())


def _often(sums: Sums, number: float, *members: ir.Member | None) -> Sums:
    """Returns the sums of a block that happens for so many members; to each as its own, once."""
    names = {member.name for member in members if member is not None}
    return {
        target: sum_ if target.owner in names else sum_.times(number)
        for target, sum_ in sums.items()
    }


def block(body: tuple[ir.Stmt, ...], ranges: IntRanges) -> Sums:
    """Goes through the statements of a block, and returns what they add."""
    sums = []
    for statement in body:
        match statement:
            case ir.Let(name=name, value=value) if value.type.kind in ("int", "real"):
                ranges = ranges.with_local(name, interval_of(value, ranges))
            case ir.Draw(name=name, low=ir.Expression() as low, high=ir.Expression() as high):
                first, _ = interval_of(low, ranges)
                _, last = interval_of(high, ranges)
                ranges = ranges.with_local(name, (first, last))
            case _:
                sums.append(_statement(statement, ranges))
    return merged(sums)


def _statement(s: ir.Stmt, ranges: IntRanges) -> Sums:
    """Returns what one statement adds, and goes through all the numbers in it."""
    match s:
        case ir.Each() | ir.Pick() | ir.First():
            return _quantified(s, ranges)
        case ir.Match():
            number = min(most_members(d, ranges.played.game) for d in (s.left, s.right))
            sums = block(s.body, ranges.inside(s.left).inside(s.right))
            return _often(sums, number, s.left.var, s.left.on, s.right.var, s.right.on)
        case ir.When() | ir.Chance():
            return _branched(s, ranges)
        case ir.Set():
            _set(s, ranges)
        case ir.Add():
            return _add(s, ranges)
        case ir.Tally():
            for part in (s.word, s.receiver):
                if part is not None:
                    visit(part, ranges)
            each = (1, 1) if s.amount is None else interval_of(s.amount, ranges)
            return _adding(Target("event", "", s.event, _name(s.receiver)), s, each)
        case ir.Send() if s.after is not None:
            visit(s.after, ranges)
            # Where it goes is looked up when it comes back: what is known now may not hold then.
            visit(s.domain, ranges.before())
        case _:
            visit_children(s, ranges)
    return {}


def _branched(s: ir.When | ir.Chance, ranges: IntRanges) -> Sums:
    """Returns what the ways through a statement add, of which one is taken."""
    ways = []
    for branch in s.branches:
        visit(branch.test, ranges)
        if isinstance(s, ir.Chance):
            ways.append(block(branch.body, ranges))
        else:
            ways.append(block(branch.body, ranges.knowing(branch.test)))
            ranges = ranges.knowing(branch.test, holds=False)
    return merged([*ways, block(s.otherwise, ranges)], all_happen=False)


def _add(s: ir.Add, ranges: IntRanges) -> Sums:
    """Returns what an `add` adds to a whole number that is capped.

    Others are reals, or proved to stay in their range.
    """
    field = written_field(s.target)
    visit_children(s.target, ranges)  # what names it: what it holds is not read
    each = interval_of(s.value, ranges)
    if field.type.kind != "int" or not declared_field(ranges.played.game, field).capped:
        return {}
    return _adding(Target("field", field.held_by.what, field.name, _name(field.owner)), s, each)


def _name(owner: ir.Expr | None) -> str:
    return owner.name if isinstance(owner, ir.Member) else ""


def _adding(target: Target, s: ir.Add | ir.Tally, each: Interval) -> Sums:
    low, high = each
    return {target: Sum(min(low, 0), max(high, 0), Part(s, each))}


def _quantified(s: ir.Each | ir.Pick | ir.First, ranges: IntRanges) -> Sums:
    """Returns what the members of a domain add together."""
    game = ranges.played.game
    number: float = most_members(s.domain, game)
    if isinstance(s, ir.Pick):
        _, picked = interval_of(s.number, ranges)
        number = min(number, picked)
    sums = block(s.body, ranges.inside(s.domain))
    if isinstance(s, ir.First):  # two lanes can reach one member
        assert isinstance(s.domain.restriction, ir.Near)
        return _often(sums, len(lanes_of(s.domain.restriction, game)))
    sums = _often(sums, number, s.domain.var, s.domain.on)
    if isinstance(s, ir.Pick):
        return merged([sums, block(s.otherwise, ranges)], all_happen=False)
    return sums


def _set(s: ir.Set, ranges: IntRanges) -> None:
    """Goes through a `set`, and keeps what a timer is set to."""
    visit_children(s.target, ranges)
    _, high = interval_of(s.value, ranges)
    if s.value.type.kind != "int" or s.target.type.high < inf:  # not a timer
        return
    field = written_field(s.target)
    held = (field.held_by.what, field.name)
    played = ranges.played
    added = _added_to(held, s.value)
    if added is None:
        played.sets[held] = max(played.sets.get(held, 0), high)
    else:
        _, most = interval_of(added, ranges)
        played.growth[held] = played.growth.get(held, 0) + max(most, 0)


def _added_to(timer: tuple[str, str], value: ir.Expr) -> ir.Expr | None:
    """Returns n if a value is `timer + n`, of any timer with this name; None for another value.

    timer: what holds it and its name.
    """
    match value:
        case ir.Named():
            return _added_to(timer, value.value)
        case ir.Arithmetic(fn=fn, args=(left, right)) if CALCULATIONS[fn].factors == (1, 1):
            for one, other in ((left, right), (right, left)):
                while isinstance(one, ir.At):
                    one = one.row
                if isinstance(one, ir.FieldRead) and (one.held_by.what, one.name) == timer:
                    return other
    return None

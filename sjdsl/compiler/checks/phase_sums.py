"""What the statements of a phase add up to: for one entry of a field, and for one count of an event.

All that is added to an entry in a phase, and all that is counted of an event in a step, is one sum. A statement is in it as often as the
quantifiers around it have members, but for the one whose member is the target: each of these has a sum of its own.
"""

from collections.abc import Iterable
from dataclasses import replace
from math import inf
from typing import Literal, NamedTuple

from sjdsl.compiler import ir
from sjdsl.compiler.checks.value_ranges import (
    Here,
    Interval,
    interval_of,
    visit,
    visit_children,
)
from sjdsl.compiler.ir.operations import CALCULATIONS
from sjdsl.compiler.ir.queries import declared_field, lanes_of, most_members, written_field
from sjdsl.compiler.ir.types import times


class Target(NamedTuple):
    """What is added to: a field, by what holds it and its name, or an event. owner: the variable whose entry it is, if it is one."""

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

    def times(self, number: float) -> "Sum":
        """Returns the sum of a block that happens so often."""
        low = times(self.low, number)
        high = times(self.high, number)
        return Sum(low, high, self.part._replace(often=times(self.part.often, number)))


Sums = dict[Target, Sum]


def merged(sums: Iterable[Sums], all_happen: bool = True) -> Sums:
    """Returns the sums of several blocks that all happen, or of which one does.

    All sums have 0 in their interval, as statements may not happen.
    """
    found: Sums = {}
    for one in sums:
        for target, own in one.items():
            other = found.get(target)
            if other is None:
                found[target] = own
                continue
            part = max(other.part, own.part, key=lambda part: part.most)
            low = other.low + own.low if all_happen else min(other.low, own.low)
            high = other.high + own.high if all_happen else max(other.high, own.high)
            found[target] = Sum(low, high, part)
    return found


def sums_of(phase: ir.Phase, here: Here) -> Sums:
    """Goes through a phase, and returns what it adds, whatever variable names the owner: two variables can be one agent or cell."""
    return merged(
        {target._replace(owner=""): own} for target, own in block(phase.body, here).items()
    )


def _often(sums: Sums, number: float, members: tuple[ir.Member | None, ...] = ()) -> Sums:
    """Returns the sums of a block that happens for so many members; to each of them as its own, once."""
    own = {member.name for member in members if member is not None}
    return {target: s if target.owner in own else s.times(number) for target, s in sums.items()}


def block(body: tuple[ir.Stmt, ...], here: Here) -> Sums:
    """Goes through the statements of a block, and returns what they add."""
    found = []
    for statement in body:
        match statement:
            case ir.Let(name=name, value=value) if value.type.kind in ("int", "real"):
                here = replace(here, locals={**here.locals, name: interval_of(value, here)})
            case ir.Draw(name=name, low=ir.Expression() as low, high=ir.Expression() as high):
                (first, _) = interval_of(low, here)
                (_, last) = interval_of(high, here)
                here = replace(here, locals={**here.locals, name: (first, last)})
            case _:
                found.append(_statement(statement, here))
    return merged(found)


def _statement(s: ir.Stmt, here: Here) -> Sums:
    """Returns what one statement adds, and goes through all the numbers in it."""
    match s:
        case ir.Each() | ir.Pick() | ir.First():
            return _quantified(s, here)
        case ir.Match():
            numbers = [most_members(domain, here.played.game) for domain in (s.left, s.right)]
            sums = block(s.body, here.inside(s.left).inside(s.right))
            return _often(sums, min(numbers), (s.left.var, s.left.on, s.right.var, s.right.on))
        case ir.When():
            sums_of_branches = []
            for branch in s.branches:
                visit(branch.test, here)
                sums_of_branches.append(block(branch.body, here.knowing(branch.test)))
                here = here.knowing(branch.test, holds=False)
            return merged([*sums_of_branches, block(s.otherwise, here)], all_happen=False)
        case ir.Chance():
            sums_of_branches = []
            for branch in s.branches:
                visit(branch.test, here)
                sums_of_branches.append(block(branch.body, here))
            return merged([*sums_of_branches, block(s.otherwise, here)], all_happen=False)
        case ir.Set():
            _set(s, here)
            return {}
        case ir.Add(target=target, value=value):
            field = written_field(target)
            visit_children(target, here)  # what names it: what it holds is not read
            is_capped = declared_field(here.played.game, field).capped
            if field.type.kind != "int" or not is_capped:
                visit(value, here)
                return {}  # a real, or a whole number that is proved to stay in its range
            return _adding(
                Target("field", field.held_by.what, field.name, _name(field.owner)),
                s,
                interval_of(value, here),
            )
        case ir.Tally():
            for part in (s.word, s.receiver):
                if part is not None:
                    visit(part, here)
            each = (1, 1) if s.amount is None else interval_of(s.amount, here)
            return _adding(Target("event", "", s.event, _name(s.receiver)), s, each)
        case ir.Send() if s.after is not None:
            visit(s.after, here)
            # Where it goes is looked up when it comes back: what is known now may not hold then.
            visit(s.domain, here.before())
            return {}
        case _:
            visit_children(s, here)
            return {}


def _name(owner: ir.Expr | None) -> str:
    return owner.name if isinstance(owner, ir.Member) else ""


def _adding(target: Target, s: ir.Add | ir.Tally, each: Interval) -> Sums:
    return {target: Sum(min(each[0], 0), max(each[1], 0), Part(s, each))}


def _quantified(s: ir.Each | ir.Pick | ir.First, here: Here) -> Sums:
    """Returns what the members of a domain add together."""
    number: float = most_members(s.domain, here.played.game)
    members: tuple[ir.Member | None, ...] = (s.domain.var, s.domain.on)
    if isinstance(s, ir.Pick):
        number = min(number, interval_of(s.number, here)[1])
    if isinstance(s, ir.First):
        assert isinstance(s.domain.restriction, ir.Near)
        number = len(lanes_of(s.domain.restriction, here.played.game))
        members = ()  # two lanes can reach one member
    sums = _often(block(s.body, here.inside(s.domain)), number, members)
    return (
        merged([sums, block(s.otherwise, here)], all_happen=False)
        if isinstance(s, ir.Pick)
        else sums
    )


def _set(s: ir.Set, here: Here) -> None:
    """Goes through a `set`, and keeps what a timer is set to."""
    visit_children(s.target, here)
    if s.value.type.kind != "int":
        visit(s.value, here)
        return
    field = written_field(s.target)
    (_, high) = interval_of(s.value, here)
    if s.target.type.high < inf:  # the range of a field
        return
    held = (field.held_by.what, field.name)
    played = here.played
    added = _counted_on(s.value, held)
    if added is None:
        played.sets[held] = max(played.sets.get(held, 0), high)
    else:
        played.growth[held] = played.growth.get(held, 0) + max(interval_of(added, here)[1], 0)


def _counted_on(value: ir.Expr, held: tuple[str, str]) -> ir.Expr | None:
    """Returns n where a timer is set to what it is and n more, or what one like it is."""
    match value:
        case ir.Named():
            return _counted_on(value.value, held)
        case ir.Arithmetic(fn=fn, args=(left, right)) if CALCULATIONS[fn].factors == (1, 1):
            for one, other in ((left, right), (right, left)):
                while isinstance(one, ir.At):
                    one = one.row
                if isinstance(one, ir.FieldRead) and (one.held_by.what, one.name) == held:
                    return other
    return None

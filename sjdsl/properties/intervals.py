"""Interval analysis: decides conditions from the ranges of the numbers in them, whatever the state."""

from typing import ClassVar

from sjdsl.compiler import ir
from sjdsl.compiler.ir.fold import VALUES, Analysis, UnknownValue
from sjdsl.compiler.ir.operations import CALCULATIONS
from sjdsl.compiler.ir.queries import phases_of
from sjdsl.compiler.ir.range_arithmetic import Range
from sjdsl.compiler.ir.ranges import compared, stays_in_float32
from sjdsl.compiler.ir.values import decided

INSTANCES = 2.0**22  # of a statement, at most: a cell of the largest map and an agent


def may_leave_float32(game: ir.Game) -> bool:
    """Returns whether the ranges don't exclude that a real of the rules, metrics or checks leaves float32, also where all instances add it."""
    parts = (*phases_of(game), *game.measures, *game.checks)
    reals = (
        node
        for part in parts
        for node in ir.walk(part)
        if ir.is_expression(node) and node.type.kind == "real"
    )
    return not all(stays_in_float32(e, INSTANCES) for e in reals)


def rounds_only_numbers(game: ir.Game) -> bool:
    """Returns whether no rule makes a whole number of infinity or NaN, which could be outside the range of a field."""
    nodes = (
        node
        for phase in phases_of(game)
        for node in ir.walk(phase)
        if isinstance(node, ir.Arithmetic)
    )
    return all(
        stays_in_float32(arg)
        for node in nodes
        if CALCULATIONS[node.fn].kind == "whole"
        for arg in node.args
    )


class Decisions(Analysis[bool]):
    """Folds conditions to whether they hold, by the ranges of the numbers in them."""

    rules: ClassVar = {
        kind: VALUES[kind]
        for kind in (ir.Truth, ir.Named, ir.Not, ir.Logic, ir.Compare, ir.InRange, ir.InWords)
    }

    def compares(self, e: ir.Expr, fn: str, left: ir.Expr, right: ir.Expr) -> bool:
        """Returns whether a comparison, `e` or a part of it, holds. Raises UnknownValue."""
        numbers = [part for part in ir.children(e) if ir.is_expression(part)]
        ranges = compared(*numbers)
        verdict = _compare(fn, ranges[numbers.index(left)], ranges[numbers.index(right)])
        if verdict is None:
            raise UnknownValue
        return verdict


def decide(e: ir.Expr) -> bool | None:
    """Returns whether a condition holds in every state and for all parameters the game takes.

    None: the ranges do not decide it.
    """
    return decided(e, Decisions())


def _compare(fn: str, a: Range, b: Range) -> bool | None:
    if not (a.sound and b.sound):
        return None
    match fn:
        case "<":
            return True if a.high < b.low else False if a.low >= b.high else None
        case "<=":
            return True if a.high <= b.low else False if a.low > b.high else None
        case ">":
            return _compare("<", b, a)
        case ">=":
            return _compare("<=", b, a)
        case "==":
            equal = a.low == a.high == b.low == b.high
            return True if equal else False if a.high < b.low or b.high < a.low else None
        case _:
            same = _compare("==", a, b)
            return None if same is None else not same

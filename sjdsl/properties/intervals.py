"""Decides conditions from the ranges of the numbers in them, whatever the state."""

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
    """Returns whether a real of the rules, metrics or checks may leave float32, by its range.

    Also where all instances of a statement add it.
    """
    for part in (*phases_of(game), *game.measures, *game.checks):
        for node in ir.walk(part):
            if ir.is_expression(node) and node.type.kind == "real":
                if not stays_in_float32(node, INSTANCES):
                    return True
    return False


def rounds_only_numbers(game: ir.Game) -> bool:
    """Returns whether no rule makes a whole number of infinity or NaN.

    Such a number could be outside the range of its field.
    """
    for phase in phases_of(game):
        for node in ir.walk(phase):
            if isinstance(node, ir.Arithmetic) and CALCULATIONS[node.fn].kind == "whole":
                if not all(map(stays_in_float32, node.args)):
                    return False
    return True


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
    """Returns whether a comparison holds for all numbers of two ranges; None: for some only."""
    if not (a.sound and b.sound):
        return None
    match fn:
        case "<":
            holds = a.high < b.low
            fails = a.low >= b.high
        case "<=":
            holds = a.high <= b.low
            fails = a.low > b.high
        case ">":
            return _compare("<", b, a)
        case ">=":
            return _compare("<=", b, a)
        case "==":
            holds = a.low == a.high == b.low == b.high
            fails = a.high < b.low or b.high < a.low
        case _:
            are_equal = _compare("==", a, b)
            return None if are_equal is None else not are_equal
    if holds:
        return True
    return False if fails else None

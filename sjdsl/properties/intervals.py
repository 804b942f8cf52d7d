"""Interval analysis: decides conditions from the ranges of the numbers in them, whatever the state."""

from sjdsl.compiler import ir
from sjdsl.compiler.ir.operations import CALCULATIONS
from sjdsl.compiler.ir.queries import phases_of
from sjdsl.compiler.ir.range_arithmetic import Range
from sjdsl.compiler.ir.ranges import compared, stays_in_float32

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


def decide(e: ir.Expr) -> bool | None:
    """Returns whether a condition holds in every state and for all parameters the game takes; None if the ranges do not decide it."""
    match e:
        case ir.Truth():
            return e.value
        case ir.Named():
            return decide(e.value)
        case ir.Not():
            inner = decide(e.value)
            return None if inner is None else not inner
        case ir.Logic():
            return _logic(e.fn == "and", [decide(a) for a in e.args])
        case ir.Compare():
            left, right = compared(e.left, e.right)
            return _compare(e.fn, left, right)
        case ir.InRange():
            low, value, high = compared(e.low, e.value, e.high)
            return _logic(True, [_compare("<=", low, value), _compare("<=", value, high)])
        case ir.InWords():
            return True if set(e.value.type.words) <= set(e.words) else None
        case _:
            return None


def _logic(is_and: bool, parts: list[bool | None]) -> bool | None:
    deciding = not is_and
    if deciding in parts:
        return deciding
    return None if None in parts else is_and


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

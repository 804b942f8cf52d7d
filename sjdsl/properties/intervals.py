"""Interval analysis: decides conditions from the ranges of the numbers in them, whatever the state."""

from sjdsl.compiler import ir
from sjdsl.compiler.ir.range_arithmetic import Range
from sjdsl.compiler.ir.ranges import compared


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

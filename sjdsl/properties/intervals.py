"""Interval analysis: decides conditions from the ranges of the numbers in them, whatever the state."""

from sjdsl.compiler import ir


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
            return _compare(e.fn, range_of(e.left), range_of(e.right))
        case ir.InRange():
            return _logic(True, [_compare("<=", range_of(e.low), range_of(e.value)), _compare("<=", range_of(e.value), range_of(e.high))])
        case ir.InWords():
            return True if set(e.value.type.words) <= set(e.words) else None
        case _:
            return None


def range_of(e: ir.Expr) -> ir.Type:
    """Returns the interval of a number; a count of all cells of a kind is exact."""
    if isinstance(e, ir.Count) and e.domain.var.who == "cell" and e.domain.restriction is None and e.domain.where is None:
        return e.type.model_copy(update={"low": e.type.high})
    return e.type


def _logic(is_and: bool, parts: list[bool | None]) -> bool | None:
    deciding = not is_and
    if deciding in parts:
        return deciding
    return None if None in parts else is_and


def _compare(fn: str, a: ir.Type, b: ir.Type) -> bool | None:
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

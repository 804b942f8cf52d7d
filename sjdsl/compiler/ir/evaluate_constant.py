"""Evaluates conditions on the numbers of a game, such as those of `require`, for given parameters."""

from collections.abc import Mapping
from typing import Any

from sjdsl.compiler import ir
from sjdsl.compiler.ir.operations import CALCULATIONS, COMPARISONS, PAYOFF_CLASSES, REDUCTIONS
from sjdsl.compiler.ir.sorts import place_of

TOLERANCE = 1e-6  # parameters are float32: `a + b == 1` must survive rounding


def holds(test: ir.Expr, params: Mapping[str, Any]) -> bool:
    """Returns whether a condition holds for these parameter values (tables nested in the order of their words)."""
    return bool(_value(test, params))


def _value(e: ir.Expr, params: Mapping[str, Any]) -> Any:
    match e:
        case ir.Number() | ir.Truth() | ir.Word():
            return e.value
        case ir.Nobody():
            return None
        case ir.ParamRef():
            return params[e.name]
        case ir.Named():
            return _value(e.value, params)
        case ir.At():
            return _value(e.row, params)[place_of(e.row.type.by[0], _value(e.key, params))]
        case ir.SumRow():
            return REDUCTIONS[e.fn].fold(_value(e.row, params))
        case ir.Arithmetic():
            return CALCULATIONS[e.fn].fold(*(_value(a, params) for a in e.args))
        case ir.Compare():
            return _compare(e.fn, _value(e.left, params), _value(e.right, params))
        case ir.InRange():
            return _value(e.low, params) - TOLERANCE <= _value(e.value, params) <= _value(e.high, params) + TOLERANCE
        case ir.InWords():
            return _value(e.value, params) in e.words
        case ir.Same():
            return _value(e.left, params) == _value(e.right, params)
        case ir.Not():
            return not _value(e.value, params)
        case ir.Logic():
            return (all if e.fn == "and" else any)(_value(a, params) for a in e.args)
        case ir.MatrixClass():
            (r, s), (t, p) = _value(e.table, params)
            return PAYOFF_CLASSES[e.name].holds(r, s, t, p)
        case _:
            raise AssertionError(e)


def _compare(fn: str, a: float, b: float) -> bool:
    """Returns whether a comparison holds, where numbers that are as good as equal are."""
    equal = abs(a - b) <= TOLERANCE * max(1.0, abs(a), abs(b))
    return bool(COMPARISONS[fn].holds(a, a if equal else b))

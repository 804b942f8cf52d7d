"""Evaluates constant expressions: two numbers (constant folding), and `require` for given parameters."""

import operator
from collections.abc import Callable, Mapping
from typing import Any

from sjdsl.compiler import ir
from sjdsl.compiler.ir.sorts import place_of

COMPARISONS: dict[str, Callable[[Any, Any], bool]] = {
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "==": operator.eq,
    "!=": operator.ne,
}
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
            row = _value(e.row, params)
            return sum(row) if e.fn == "sum" else min(row) if e.fn == "min" else max(row)
        case ir.Arithmetic(fn="neg"):
            return -_value(e.args[0], params)
        case ir.Arithmetic(fn="round"):
            return round(_value(e.args[0], params))
        case ir.Arithmetic(fn="min" | "max"):
            return (min if e.fn == "min" else max)(_value(a, params) for a in e.args)
        case ir.Arithmetic():
            return fold(e.fn, _value(e.args[0], params), _value(e.args[1], params))
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
            return matrix_class(e.name, _value(e.table, params))
        case _:
            raise AssertionError(e)


def fold(fn: str, a: float, b: float) -> float:
    """Returns the constant `a fn b`."""
    match fn:
        case "+":
            return a + b
        case "-":
            return a - b
        case "*":
            return a * b
        case "/":
            return a / b
        case "//":
            return a // b
        case "%":
            return a % b
    raise AssertionError(fn)


def _compare(fn: str, a: float, b: float) -> bool:
    equal = abs(a - b) <= TOLERANCE * max(1.0, abs(a), abs(b))
    match fn:
        case "==":
            return equal
        case "!=":
            return not equal
        case "<":
            return a < b and not equal
        case "<=":
            return a < b or equal
        case ">":
            return a > b and not equal
        case _:
            return a > b or equal


def matrix_class(name: str, table: tuple[tuple[float, float], tuple[float, float]]) -> bool:
    """Returns whether a table of the row player's payoffs (first word: cooperate) is of a class of 2 x 2 games.

    Source: Macy and Flache 2002, the orders of R, S, T, P: prisoner's dilemma T > R > P > S and 2R > T + S;
    stag hunt R > T >= P > S; chicken T > R > S > P. Their 2R > T + S is not asked of a chicken game: taking turns
    may pay more than cooperating, as in the one of Melting Pot (3, 2 / 5, 0).
    """
    (r, s), (t, p) = table
    match name:
        case "prisoners_dilemma":
            return t > r > p > s and 2 * r > t + s
        case "stag_hunt":
            return r > t >= p > s
        case "chicken":
            return t > r > s > p
    raise AssertionError(name)

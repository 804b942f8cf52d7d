"""Evaluates conditions on the numbers of a game, such as those of `require`, for given parameters.

Whole numbers are exact. Reals are rounded to float32 at each step, as in play, so that what a `require` says of them holds there, too.
"""

from collections.abc import Callable, Mapping
from operator import mul
from typing import Any

from sjdsl.compiler import ir
from sjdsl.compiler.ir.equivalence import is_exact
from sjdsl.compiler.ir.operations import CALCULATIONS, COMPARISONS, PAYOFF_CLASSES, REDUCTIONS
from sjdsl.compiler.ir.range_arithmetic import nearest

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
        case ir.Named() | ir.Narrowed():
            return _value(e.value, params)
        case ir.At() if e.key.type.kind == "mix":
            return sum(map(mul, _value(e.key, params), _value(e.row, params)))
        case ir.At():
            return _value(e.row, params)[e.row.type.by[0].place_of(_value(e.key, params))]
        case ir.SumRow():
            return REDUCTIONS[e.fn].fold(_value(e.row, params))
        case ir.Lowest():
            level, row = e.row.type.by[0], _value(e.row, params)
            place = ([place for place, entry in enumerate(row) if entry > 0] or range(len(row)))[
                -1 if e.last else 0
            ]
            return level.names[place] if e.type.kind == "word" else level.first + place
        case ir.Mix():
            row = _value(e.row, params)
            return tuple(entry / sum(row) for entry in row)
        case ir.ShiftRow():
            row, filler = _value(e.row, params), _value(e.filler, params)
            return tuple(
                row[place - e.by] if 0 <= place - e.by < len(row) else filler
                for place in range(len(row))
            )
        case ir.Case():
            return _value(
                next(arm.value for arm in e.arms if _applies(arm, _value(e.subject, params))),
                params,
            )
        case ir.Arithmetic():
            return _entry_by_entry(_fold(e), *(_value(a, params) for a in e.args))
        case ir.Compare():
            a, b = _value(e.left, params), _value(e.right, params)
            return compares(e.fn, a, b, is_exact(e), _tolerance(e.left, e.right))
        case ir.InRange():
            low, value, high = (_value(part, params) for part in (e.low, e.value, e.high))
            exact, tolerance = is_exact(e), _tolerance(e.low, e.value, e.high)
            return compares("<=", low, value, exact, tolerance) and compares(
                "<=", value, high, exact, tolerance
            )
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


def compares(fn: str, a: float, b: float, exact: bool, tolerance: float = 0.0) -> bool:
    """Returns whether a comparison holds; `exact`: of whole numbers; others are rounded to float32, and may be as good as equal."""
    if not exact:
        a, b = nearest(a), nearest(b)
    equal = abs(a - b) <= tolerance * max(1.0, abs(a), abs(b))
    return bool(COMPARISONS[fn].holds(a, a if equal else b))


def _tolerance(*numbers: ir.Expr) -> float:
    """Returns by how much numbers that are as good as equal differ, relative: nothing where a whole number is compared that can vary."""
    varying = any(e.type.kind == "int" and e.type.low < e.type.high for e in numbers)
    return 0.0 if varying or all(e.type.kind == "int" for e in numbers) else TOLERANCE


def _fold(e: ir.Arithmetic) -> Callable[..., float]:
    """Returns what calculates a number from others as in play, where reals are float32."""
    fold = CALCULATIONS[e.fn].fold
    if e.type.kind == "real":
        return lambda *numbers: nearest(fold(*map(nearest, numbers)))
    if any(a.type.kind == "real" for a in e.args):
        return lambda *numbers: fold(*map(nearest, numbers))
    return fold


def _entry_by_entry(fold: Callable[..., Any], *values: Any) -> Any:
    """Returns what is calculated from numbers, or from rows and tables with the same keys."""
    if isinstance(values[0], tuple):
        return tuple(_entry_by_entry(fold, *entries) for entries in zip(*values, strict=True))
    return fold(*values)


def _applies(arm: ir.Arm, subject: bool | int | str) -> bool:
    """Returns whether an arm of a `case` is for this word, truth or number."""
    if isinstance(subject, bool):
        subject = "yes" if subject else "no"
    if isinstance(subject, str):
        return subject in arm.words
    return (arm.low is None or arm.low <= subject) and (arm.high is None or subject <= arm.high)

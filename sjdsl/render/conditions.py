"""Evaluates the condition of a `look` for each cell of a kind, or each agent, from the arrays of a state."""

from collections.abc import Mapping
from typing import Any, assert_never

import numpy as np

from sjdsl.compiler import ir
from sjdsl.compiler.ir.operations import COMPARISONS, REDUCTIONS


def holds(condition: ir.Expr, fields: Mapping[str, np.ndarray], count: int) -> np.ndarray:
    """Returns `[count]` bool.

    Args:
      condition: over one cell or agent; the compiler lets it read its fields, words and numbers alone.
      fields: name of a field -> its values, `[count, ...]`.
    """
    return np.broadcast_to(_value(condition, fields), (count,)).astype(bool)


def fields_read(condition: ir.Expr) -> frozenset[str]:
    """Returns the names of the fields that a condition reads."""
    return frozenset(node.name for node in ir.walk(condition) if isinstance(node, ir.FieldRead))


def _value(e: ir.Expr, fields: Mapping[str, np.ndarray]) -> Any:
    """Returns words as texts, agents as numbers with -1 for nobody, sets of agents as bits."""
    match e:
        case ir.Number() | ir.Word() | ir.Truth():
            return e.value
        case ir.Nobody():
            return -1
        case ir.FieldRead():
            return np.asarray(e.type.words)[fields[e.name]] if e.type.kind == "word" else fields[e.name]
        case ir.At(key=ir.Word(value=key) | ir.Number(value=key)):
            return _value(e.row, fields)[:, e.row.type.by[0].place_of(key)]  # type: ignore[arg-type]
        case ir.SumRow():
            return getattr(np, REDUCTIONS[e.fn].array)(_value(e.row, fields), axis=1)
        case ir.Compare():
            return COMPARISONS[e.fn].holds(_value(e.left, fields), _value(e.right, fields))
        case ir.Same():
            return np.equal(_value(e.left, fields), _value(e.right, fields))
        case ir.InRange():
            value = _value(e.value, fields)
            return (value >= _value(e.low, fields)) & (value <= _value(e.high, fields))
        case ir.InWords():
            return np.isin(_value(e.value, fields), e.words)
        case ir.IsEmpty():
            return _value(e.container, fields) == 0
        case ir.Not():
            return np.logical_not(_value(e.value, fields))
        case ir.Logic():
            join = np.logical_and if e.fn == "and" else np.logical_or
            return join.reduce(np.broadcast_arrays(*(_value(a, fields) for a in e.args)))
        case ir.Named() | ir.Narrowed():
            return _value(e.value, fields)
        case _:
            assert_never(e)  # type: ignore[arg-type]  # the compiler refuses all others in a `look`

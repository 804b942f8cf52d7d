"""Compiles the expressions of checks to a function of the compiled state."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

from sjdsl.compiler import ir
from sjdsl.compiler.diagnostics.tree import rewrite
from sjdsl.compiler.emit.statements import function_lines
from sjdsl.compiler.ir.names import identifier
from sjdsl.compiler.lower import new_module
from sjdsl.compiler.lower.axes import as_dtype
from sjdsl.compiler.lower.scope import IterationScope
from sjdsl.compiler.lower.writer import Writer
from sjdsl.compiler.program import Function
from sjdsl.compiler.program.expressions import Expression, as_array, call, zeros
from sjdsl.compiler.program.expressions import Sequence as ListOf
from sjdsl.policies.lowering import namespace
from sjdsl.properties.monitors import Total


@dataclass(frozen=True)
class Lowered:
    """The expressions of checks as one function.

    values: (state, params, state before the step) -> `[K]` float32, one for each expression.
    totals: event and enum value -> the attribute of `params` that holds its total; totals_before:
    the same for the totals before the step.
    """

    values: Callable[[Any, Any, Any], Any]
    totals: dict[Total, str]
    totals_before: dict[Total, str]


def lower_checks(game: ir.Game, expressions: Sequence[ir.Expr]) -> Lowered:
    """Returns the function. Raises NotSupported for what the compiler cannot say exactly."""
    totals: dict[Total, str] = {}
    totals_before: dict[Total, str] = {}
    module = new_module(game)
    w = Writer(module)
    numbers: list[Expression] = []
    for e in expressions:
        readable = _reading_params(e, totals, totals_before)
        value = as_dtype(w.value(readable, IterationScope()), "f32")
        numbers.append(as_array(value.node, "f32"))
    stacked = call("jnp.stack", ListOf(tuple(numbers), is_list=True))
    w.give_back(stacked if numbers else zeros("f32", 0))
    parameters = (("state", "object"), ("params", "object"), ("before", "object"))
    function = Function("values", parameters, "object", "", tuple(w.body))
    names = namespace(module)
    exec("\n".join(function_lines(function)), names)
    return Lowered(names["values"], totals, totals_before)


def with_totals(params: Any, totals: dict[str, Any]) -> Any:
    """Returns the parameters together with the totals of events."""
    return SimpleNamespace(**vars(params), **totals)


def _reading_params(
    e: ir.Expr, totals: dict[Total, str], totals_before: dict[Total, str]
) -> ir.Expr:
    """Returns an expression that reads parameters in place of totals of events.

    Adds the names of these parameters to `totals`, and inside `before(...)` to `totals_before`.
    """

    def inside_before(node: Any) -> Any:
        if not isinstance(node, ir.Before):
            return node
        return rewrite(node, lambda inner: _as_param(inner, totals_before, "_earlier"))

    without_totals_before = rewrite(e, inside_before)
    return rewrite(without_totals_before, lambda node: _as_param(node, totals, "_total"))


def _as_param(node: Any, names: dict[Total, str], prefix: str) -> Any:
    """Returns the parameter in place of a total, whose name is added to `names`; others as is."""
    if not isinstance(node, ir.EventTotal):
        return node
    name = f"{prefix}_{node.name}"
    if node.word:
        word = node.word.replace(" ", "_").replace("-", "minus_")
        name = f"{name}_of_{word}"
    name = identifier(name)
    names[node.name, node.word] = name
    return ir.ParamRef(type=node.type, name=name, origin=node.origin)

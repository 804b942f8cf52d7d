"""Compiles the expressions of checks to a function of the compiled state."""

from collections.abc import Callable
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
from sjdsl.compiler.program.expressions import DTYPES, Literal, Sequence, as_array, call
from sjdsl.policies.lowering import namespace

Total = tuple[str, str | None]  # an event, and its word or None


@dataclass(frozen=True)
class Lowered:
    """values: (state, params, before: the state before the step) -> float32 `[expressions]`.

    totals: the attributes of `params` that hold totals, by event and word; earlier: those that hold the totals before the step.
    """

    values: Callable[[Any, Any, Any], Any]
    totals: dict[Total, str]
    earlier: dict[Total, str]


def lower_checks(game: ir.Game, expressions: list[ir.Expr]) -> Lowered:
    """Returns the function. Raises NotSupported for what the compiler cannot say exactly."""
    module = new_module(game)
    totals, earlier = dict[Total, str](), dict[Total, str]()
    w = Writer(module)
    numbers = [
        as_dtype(w.value(_with_totals(e, totals, earlier), IterationScope()), "f32")
        for e in expressions
    ]
    parts = tuple(as_array(number.node, "f32") for number in numbers)
    w.give_back(
        call("jnp.stack", Sequence(parts, is_list=True))
        if parts
        else call("jnp.zeros", Literal(0), DTYPES["f32"])
    )
    parameters = tuple((parameter, "object") for parameter in ("state", "params", "before"))
    names = namespace(module)
    exec(
        "\n".join(function_lines(Function("values", parameters, "object", "", tuple(w.body)))),
        names,
    )
    return Lowered(names["values"], totals, earlier)


def with_totals(params: Any, totals: dict[str, Any]) -> Any:
    """Returns the parameters together with the totals of events."""
    return SimpleNamespace(
        **{name: getattr(params, name) for name in params.__dataclass_fields__}, **totals
    )


def _with_totals(e: ir.Expr, totals: dict[Total, str], earlier: dict[Total, str]) -> ir.Expr:
    """Replaces the totals of events by parameters of the game, others for those before the step."""

    def then(node: Any) -> Any:
        return (
            rewrite(node, lambda inner: _total(inner, earlier, "_earlier"))
            if isinstance(node, ir.Before)
            else node
        )

    return rewrite(rewrite(e, then), lambda node: _total(node, totals, "_total"))


def _total(node: Any, totals: dict[Total, str], prefix: str) -> Any:
    if not isinstance(node, ir.EventTotal):
        return node
    name = identifier(
        f"{prefix}_{node.name}"
        + (f"_of_{node.word.replace(' ', '_').replace('-', 'minus_')}" if node.word else "")
    )
    totals[node.name, node.word] = name
    return ir.ParamRef(type=node.type, name=name, origin=node.origin)

"""Compiles the expressions of checks to functions of the compiled state, and finds the targets of `seek` policies.

ir.Game -> `values(state, params, before)`, one `seek(state, params)` for each policy that walks somewhere
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any

from sjdsl.compiler import ir
from sjdsl.compiler.diagnostics.tree import rewrite
from sjdsl.compiler.emit.statements import function_lines
from sjdsl.compiler.ir.names import identifier
from sjdsl.compiler.lower import new_module, state_reads
from sjdsl.compiler.lower.axes import as_dtype, iota, spread
from sjdsl.compiler.lower.domains import enter
from sjdsl.compiler.lower.scope import AgentVar, CellVar, IterationScope
from sjdsl.compiler.lower.writer import Module, Writer
from sjdsl.compiler.program import Function
from sjdsl.compiler.program.expressions import DTYPES, Attribute, Binary, Call, Expression, Literal, Sequence, as_array, call
from sjdsl.policies.lowering import namespace

Total = tuple[str, str | None]  # an event, and its word or None


@dataclass(frozen=True)
class Lowered:
    """values: (state, params, before: the state before the step) -> float32 `[expressions]`.

    totals: the attributes of `params` that hold totals, by event and word; earlier: those that hold the totals before the step.

    seeks: (state, params) -> (map cells `[N, M]` int32 of the members for each agent, whether each is a member `[N, M]` bool).
    """

    values: Callable[[Any, Any, Any], Any]
    totals: dict[Total, str]
    earlier: dict[Total, str]
    seeks: tuple[Callable[[Any, Any], tuple[Any, Any]], ...]


def lower_checks(game: ir.Game, expressions: list[ir.Expr], domains: list[ir.Domain]) -> Lowered:
    """Returns the functions. Raises NotSupported for what the compiler cannot say exactly."""
    module = new_module(game)
    totals, earlier = dict[Total, str](), dict[Total, str]()
    texts = [_values([_with_totals(e, totals, earlier) for e in expressions], module)]
    texts += [_seek(domain, i, module) for i, domain in enumerate(domains)]
    names = namespace(module)
    exec("\n".join(texts), names)
    seeks = tuple(names[f"seek_{i}"] for i in range(len(domains)))
    return Lowered(names["values"], totals, earlier, seeks)


def with_totals(params: Any, totals: dict[str, Any]) -> Any:
    """Returns the parameters together with the totals of events."""
    return SimpleNamespace(**{name: getattr(params, name) for name in params.__dataclass_fields__}, **totals)


def _with_totals(e: ir.Expr, totals: dict[Total, str], earlier: dict[Total, str]) -> ir.Expr:
    """Replaces the totals of events by parameters of the game, others for those before the step."""

    def then(node: Any) -> Any:
        return rewrite(node, lambda inner: _total(inner, earlier, "_earlier")) if isinstance(node, ir.Before) else node

    return rewrite(rewrite(e, then), lambda node: _total(node, totals, "_total"))


def _total(node: Any, totals: dict[Total, str], prefix: str) -> Any:
    if not isinstance(node, ir.EventTotal):
        return node
    name = identifier(f"{prefix}_{node.name}" + (f"_of_{node.word.replace(' ', '_').replace('-', 'minus_')}" if node.word else ""))
    totals[node.name, node.word] = name
    return ir.ParamRef(type=node.type, name=name, origin=node.origin)


def _values(expressions: list[ir.Expr], module: Module) -> str:
    w = Writer(module)
    numbers = [as_dtype(w.value(e, IterationScope()), "f32") for e in expressions]
    parts = tuple(as_array(number.node, "f32") for number in numbers)
    if parts:
        w.give_back(call("jnp.stack", Sequence(parts, is_list=True)))
    else:
        w.give_back(call("jnp.zeros", Literal(0), DTYPES["f32"]))
    return _function("values", w, "before")


def _seek(domain: ir.Domain, number: int, module: Module) -> str:
    w = Writer(module)
    agents = w.axis("agent", module.agents)
    inner = enter(domain, IterationScope(axes=(agents,), variables={"agent": AgentVar(iota(agents), agents)}), w)
    member = inner.variables[domain.var.name]
    at = state_reads.cell(member, w) if isinstance(member, CellVar) else state_reads.position(member, w)
    row, col = (_less(Binary(op, at.node, Literal(module.layout.cols)), module.layout.pad) for op in ("//", "%"))
    cells = replace(at, node=Binary("+", Binary("*", row, Literal(module.layout.width)), col))
    w.give_back(*(_of_agents(spread(value, inner.axes), inner) for value in (cells, inner.mask)))
    return _function(f"seek_{number}", w)


def _less(node: Expression, number: int) -> Expression:
    return Binary("-", node, Literal(number))


def _of_agents(node: Expression, inner: IterationScope) -> Expression:
    """Returns a value over all axes as `[agents, members]`."""
    if len(inner.axes) == 2:
        return node
    return Call(Attribute(node, "reshape"), (inner.axes[0].extent, Literal(-1)))


def _function(name: str, w: Writer, *more: str) -> str:
    parameters = tuple((parameter, "object") for parameter in ("state", "params", *more))
    return "\n".join(function_lines(Function(name, parameters, "object", "", tuple(w.body))))

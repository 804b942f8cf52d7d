"""Compiles the expressions of checks to functions of the compiled state, and finds the targets of `seek` policies.

ir.Game -> `values(state, params)`, one `seek(state, params)` for each policy that walks somewhere
"""

from collections.abc import Callable
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import jax.numpy as jnp

from sjdsl.compiler import ir
from sjdsl.compiler.ir.names import KERNELS, identifier
from sjdsl.compiler.lower import state_reads
from sjdsl.compiler.lower.axes import Axis, Value, aligned, as_dtype
from sjdsl.compiler.lower.domains import enter
from sjdsl.compiler.lower.expressions import lower
from sjdsl.compiler.lower.map_tables import Layout
from sjdsl.compiler.lower.scope import AgentVar, CellVar, Frame, Module, Writer, iota
from sjdsl.compiler.optimise.rewrite import rewrite
from sjdsl.compiler.program import Line

Total = tuple[str, str | None]  # an event, and its word or None


@dataclass(frozen=True)
class Lowered:
    """values: (state, params) -> float32 `[expressions]`. totals: the attributes of `params` that hold totals, by event and word.

    seeks: (state, params) -> (map cells `[N, M]` int32 of the members for each agent, whether each is a member `[N, M]` bool).
    """

    values: Callable[[Any, Any], Any]
    totals: dict[Total, str]
    seeks: tuple[Callable[[Any, Any], tuple[Any, Any]], ...]


def lower_checks(game: ir.Game, expressions: list[ir.Expr], domains: list[ir.Domain]) -> Lowered:
    """Returns the functions. Raises NotSupported for what the compiler cannot say exactly."""
    module = Module(game, Layout(game))
    totals: dict[Total, str] = {}
    texts = [_values([rewrite(e, lambda node: _total(node, totals)) for e in expressions], module)]
    texts += [_seek(domain, i, module) for i, domain in enumerate(domains)]
    names = _namespace(module)
    exec("\n".join(texts), names)
    seeks = tuple(names[f"seek_{i}"] for i in range(len(domains)))
    return Lowered(names["values"], totals, seeks)


def with_totals(params: Any, totals: dict[str, Any]) -> Any:
    """Returns the parameters together with the totals of events."""
    return SimpleNamespace(**{name: getattr(params, name) for name in params.__dataclass_fields__}, **totals)


def _total(node: Any, totals: dict[Total, str]) -> Any:
    """Replaces the total of an event by a parameter of the game."""
    if not isinstance(node, ir.EventTotal):
        return node
    name = identifier(f"_total_{node.name}" + (f"_of_{node.word}" if node.word else ""))
    totals[node.name, node.word] = name
    return ir.ParamRef(type=node.type, name=name, origin=node.origin)


def _values(expressions: list[ir.Expr], module: Module) -> str:
    w = Writer(module)
    parts = []
    for e in expressions:
        value = as_dtype(lower(e, Frame(), w), "f32")
        parts.append(f"jnp.asarray({value.text}, jnp.float32)")
    w.line(f"return jnp.stack([{', '.join(parts)}])" if parts else "return jnp.zeros(0, jnp.float32)")
    return _function("values", w)


def _seek(domain: ir.Domain, number: int, module: Module) -> str:
    w = Writer(module)
    agents = w.axis("agent", module.num_agents)
    seeker = AgentVar(iota(agents), agents)
    inner = enter(domain, Frame(axes=(agents,), variables={"agent": seeker}), w)
    member = inner.variables[domain.var.name]
    at = state_reads.cell(member, w) if isinstance(member, CellVar) else state_reads.position(member, w)
    mask = inner.mask or Value("True", "bool", literal=True)
    layout = module.layout
    cell = f"(({at.text}) // {layout.cols} - {layout.pad}) * {layout.width} + ({at.text}) % {layout.cols} - {layout.pad}"
    w.line(f"return {_spread(Value(cell, 'i32', at.axes), inner.axes)}, {_spread(mask, inner.axes)}")
    return _function(f"seek_{number}", w)


def _spread(value: Value, axes: tuple[Axis, ...]) -> str:
    """Returns the text of a value as `[agents, members]`."""
    shape = ", ".join(str(axis.size) for axis in axes)
    whole = f"jnp.broadcast_to({aligned(value, axes) if value.axes else value.text}, ({shape},))"
    return whole if len(axes) == 2 else f"{whole}.reshape({axes[0].size}, -1)"


def _function(name: str, w: Writer) -> str:
    return f"def {name}(state, params):\n" + "\n".join(f"    {line.text}" for line in w.lines if isinstance(line, Line))


def _namespace(module: Module) -> dict[str, Any]:
    from importlib import import_module

    names: dict[str, Any] = {"jnp": jnp}
    for home, kernels in KERNELS.items():
        names |= {kernel: getattr(import_module(home), kernel) for kernel in kernels}
    return names | {c.name: jnp.asarray(c.value) for c in module.constants.values()}

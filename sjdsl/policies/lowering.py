"""Lowers what the rules of a policy read, conditions and domains, to functions of the compiled state.

ir.ScriptedPolicy -> for each of its rules functions `(state, params) -> arrays`
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from importlib import import_module
from typing import Any

import jax.numpy as jnp
import numpy as np

from sjdsl.compiler import ir
from sjdsl.compiler.emit.expressions import text
from sjdsl.compiler.emit.statements import function_lines
from sjdsl.compiler.ir.names import KERNELS
from sjdsl.compiler.ir.queries import action_named
from sjdsl.compiler.lower import NotSupported, new_module, state_reads
from sjdsl.compiler.lower.axes import Value, iota, spread
from sjdsl.compiler.lower.chosen import action_number
from sjdsl.compiler.lower.domains import enter, is_empty
from sjdsl.compiler.lower.scope import AgentVar, CellVar, IterationScope
from sjdsl.compiler.lower.writer import Module, Writer
from sjdsl.compiler.program import Function
from sjdsl.compiler.program.expressions import Attribute, Binary, Call, Literal, Name, Sequence
from sjdsl.runtime import geometry

Read = Callable[[Any, Any], Any]


@dataclass(frozen=True, eq=False)
class Cells:
    """The cells of the members of a domain, for each agent that acts or, with one row, for all alike.

    read: (state, params) -> members `[N or 1, M]` bool, and their cells `[N or 1, M]` int32, `row * width + column` of the map.
    numbers: where the members are all cells of some kinds, the number among them of each cell of the map, `[H * W]` int32, past their end for
    others; then `read` gives the members alone.
    """

    read: Read
    numbers: np.ndarray | None = None


@dataclass(frozen=True, eq=False)
class LoweredRule:
    """A rule with functions of the state: `condition` gives `[N]` bool; `sought`, `avoided` are None where there can be none.

    taken: gives the action each agent ends in, `[N]` int32, of a rule that says one with arguments; None: always `rule.action`.
    """

    rule: ir.PolicyRule
    condition: Read | None = None
    sought: Cells | None = None
    avoided: Cells | None = None
    taken: Read | None = None


def lower_policy(policy: ir.ScriptedPolicy, game: ir.Game) -> tuple[list[LoweredRule], int]:
    """Returns the rules of a policy in order, and the padding of the frame in which they read positions.

    Raises NotSupported for what the compiler cannot say exactly.
    """
    module = new_module(
        game.rules.model_copy(update={"shapes": (*game.shapes, *game.policy_shapes)})
    )
    names: dict[str, Any] = {}

    def function(w: Writer) -> Read:
        name = f"read_{len(names)}"
        exec(
            "\n".join(
                function_lines(
                    Function(
                        name,
                        (("state", "object"), ("params", "object")),
                        "object",
                        "",
                        tuple(w.body),
                    )
                )
            ),
            names,
        )
        read: Read = names[name]
        return read

    def cells(domain: ir.Domain | None) -> Cells | None:
        w = Writer(module)
        if domain is None or is_empty(domain, w):
            return None
        numbers = _write_members(domain, module, w)
        return Cells(function(w), numbers)

    def of_each(value: Callable[[IterationScope, Writer], Value]) -> Read:
        w = Writer(module)
        scope = _of_agents(w)
        w.give_back(spread(value(scope, w), scope.axes))
        return function(w)

    def taken(rule: ir.PolicyRule) -> Read | None:
        if isinstance(rule, ir.Go) or not rule.chosen:
            return None
        return of_each(
            lambda scope, w: action_number(action_named(game, rule.chosen), rule.given, scope, w)[0]
        )

    def lowered(rule: ir.PolicyRule) -> LoweredRule:
        if isinstance(rule, ir.Act):
            return LoweredRule(
                rule, of_each(lambda scope, w: w.value(rule.condition, scope)), taken=taken(rule)
            )
        return LoweredRule(rule, None, cells(rule.domain), cells(rule.avoided), taken(rule))

    rules = [lowered(rule) for rule in policy.rules]
    names.update(namespace(module))  # what the functions read, known once all of them are written
    return rules, module.layout.pad


def _of_agents(w: Writer) -> IterationScope:
    axis = w.axis("agent", w.module.agents)
    return IterationScope(axes=(axis,), variables={"agent": AgentVar(iota(axis), axis)})


def _write_members(domain: ir.Domain, module: Module, w: Writer) -> np.ndarray | None:
    """Writes what a function of the members gives back; returns `Cells.numbers`."""
    outer = _of_agents(w)
    inner = enter(domain, outer, w)
    added = tuple(axis for axis in inner.axes if axis not in outer.axes)
    if len(added) > 1:
        raise NotSupported("a domain of several axes in a policy", domain.origin)
    member = inner.variables[domain.var.name]
    mask = inner.mask
    whole = isinstance(member, CellVar) and member.axis is not None
    at = None if whole else _map_cells(member, module, w)
    depends = any(
        axis in value.axes for value in (mask, *([] if at is None else [at])) for axis in outer.axes
    )
    axes = (*outer.axes, *added) if depends else added
    rows_of_members = Sequence((Literal(module.num_agents if depends else 1), Literal(-1)))
    values = (
        mask,
        *([] if at is None else [at]),
    )  # one without axes may be a plain number, which has no method `reshape`
    w.give_back(
        *(
            Call(Attribute(Name("jnp"), "reshape"), (spread(value, axes), rows_of_members))
            for value in values
        )
    )
    if not whole:
        return None
    rows = module.game.rows
    return geometry.site_numbers(
        rows, 0, geometry.cells_of(rows, 0, module.layout.glyphs(domain.var.kinds))
    )


def _map_cells(member: AgentVar | CellVar, module: Module, w: Writer) -> Value:
    at = (
        state_reads.cell(member, w)
        if isinstance(member, CellVar)
        else state_reads.position(member, w)
    )
    pad, cols = Literal(module.layout.pad), Literal(module.layout.cols)
    row, col = (Binary("-", Binary(op, at.node, cols), pad) for op in ("//", "%"))
    return replace(at, node=Binary("+", Binary("*", row, Literal(module.layout.width)), col))


def namespace(module: Module) -> dict[str, Any]:
    """Returns the names that functions of a module use: kernels, its constants and its numbers."""
    names: dict[str, Any] = {"jnp": jnp}
    for home, kernels in KERNELS.items():
        names |= {kernel: getattr(import_module(home), kernel) for kernel in kernels}
    names |= {"NUM_AGENTS": module.num_agents, "MAP": module.game.rows, "PAD": module.layout.pad}
    exec("\n".join(f"{c.name} = {text(c.value)}" for c in module.constants.values()), names)
    return names | {n.name: n.value for n in module.numbers.values()}

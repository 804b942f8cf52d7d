"""Lowers the conditions and domains of a policy's rules to functions of the compiled state.

ir.ScriptedPolicy -> for each of its rules, functions `(state, params) -> arrays`
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import jax.numpy as jnp
import numpy as np

from sjdsl.compiler import ir
from sjdsl.compiler.emit.expressions import text
from sjdsl.compiler.emit.statements import function_lines
from sjdsl.compiler.ir.names import KERNELS
from sjdsl.compiler.ir.queries import action_named, closes_paths
from sjdsl.compiler.lower import NotSupported, new_module, state_reads
from sjdsl.compiler.lower.axes import Value, iota, spread
from sjdsl.compiler.lower.chosen import action_number
from sjdsl.compiler.lower.domains import enter, is_empty
from sjdsl.compiler.lower.scope import AgentVar, CellVar, IterationScope
from sjdsl.compiler.lower.writer import Module, Writer
from sjdsl.compiler.program import Function
from sjdsl.compiler.program.expressions import call
from sjdsl.runtime import geometry

Read = Callable[[Any, Any], Any]


@dataclass(frozen=True, eq=False)
class Cells:
    """The cells of a domain's members: for each agent that acts or, with one row, for all agents.

    read: (state, params) -> members `[N or 1, M]` bool, and their cells `[N or 1, M]` int32,
    `row * width + column` of the map. Without cells if `numbers` isn't None.
    numbers: if the domain is of all cells of some kinds, the index among them of each cell of the
    map, `[H * W]` int32, one past the end for other cells.
    """

    read: Read
    numbers: np.ndarray | None = None


@dataclass(frozen=True, eq=False)
class LoweredRule:
    """A rule with functions of the state.

    condition: gives `[N]` bool, None if the rule has none; sought, avoided: None if there are no
    such cells.
    action: of a rule whose action has arguments, gives that of each agent, `[N]` int32; None for a
    rule with one action, `rule.action`.
    """

    rule: ir.PolicyRule
    condition: Read | None = None
    sought: Cells | None = None
    avoided: Cells | None = None
    action: Read | None = None


@dataclass(frozen=True, eq=False)
class LoweredPolicy:
    """A policy with functions of the state.

    rules: in order. closed: cells that each agent can't enter, by what it is. pad: the padding of
    the frame of the positions in the state.
    """

    rules: tuple[LoweredRule, ...]
    closed: tuple[Cells, ...]
    pad: int


def lower_policy(policy: ir.ScriptedPolicy, game: ir.Game) -> LoweredPolicy:
    """Returns a policy with functions of the state.

    Raises NotSupported for what the compiler doesn't support.
    """
    shapes = (*game.shapes, *game.policy_shapes)
    module = new_module(game.rules.model_copy(update={"shapes": shapes}))
    names: dict[str, Any] = {}

    def make_function(w: Writer) -> Read:
        """Returns what `w` has written, as a function; it is one of `names`."""
        name = f"read_{len(names)}"
        arguments = (("state", "object"), ("params", "object"))
        lines = function_lines(Function(name, arguments, "object", "", tuple(w.body)))
        exec("\n".join(lines), names)
        read: Read = names[name]
        return read

    def lower_cells(domain: ir.Domain | None, on: ir.Member | None = None) -> Cells | None:
        """Returns the cells of a domain; None if it can't have any. on: the cell underfoot."""
        w = Writer(module)
        if domain is None or is_empty(domain, w):
            return None
        numbers = _write_members(domain, on, module, w)
        return Cells(make_function(w), numbers)

    def lower_for_agents(
        value: Callable[[IterationScope, Writer], Value], on: ir.Member | None = None
    ) -> Read:
        """Returns a function that gives a value for each agent, `[N]`. on: the cell underfoot."""
        w = Writer(module)
        scope = _agents_scope(on, w)
        w.give_back(spread(value(scope, w), scope.axes))
        return make_function(w)

    def lower_action(rule: ir.PolicyRule) -> Read | None:
        """Returns `LoweredRule.action`."""
        if isinstance(rule, ir.Go) or not rule.chosen:
            return None
        action = action_named(game, rule.chosen)

        def number(scope: IterationScope, w: Writer) -> Value:
            value, _ = action_number(action, rule.given, scope, w)
            return value

        return lower_for_agents(number, rule.on)

    def lower_condition(rule: ir.PolicyRule) -> Read | None:
        """Returns `LoweredRule.condition`."""
        test = rule.condition
        if test is None:
            return None
        return lower_for_agents(lambda scope, w: scope.mask & w.value(test, scope), rule.on)

    def lower_rule(rule: ir.PolicyRule) -> LoweredRule:
        """Returns a rule with its functions."""
        condition = lower_condition(rule)
        if isinstance(rule, ir.Act):
            return LoweredRule(rule, condition, action=lower_action(rule))
        return LoweredRule(
            rule,
            condition,
            sought=lower_cells(rule.domain, rule.on),
            avoided=lower_cells(rule.avoided, rule.on),
            action=lower_action(rule),
        )

    can_apply = [
        rule
        for rule in policy.rules
        if rule.on is None or module.layout.num_cells(rule.on.kinds) > 0
    ]
    rules = tuple(lower_rule(rule) for rule in can_apply)
    closed = []
    if any(not isinstance(rule, ir.Act) for rule in can_apply):
        for domain in _closing(game):
            cells = lower_cells(domain)
            if cells is not None:
                closed.append(cells)
    # What the functions use is known when all of them have been written.
    names.update(namespace(module))
    return LoweredPolicy(rules, tuple(closed), module.layout.pad)


def _closing(game: ir.Game) -> Iterator[ir.Domain]:
    """Yields the domains of cells that an agent can't enter by what it is."""
    for kind in game.kinds:
        cell = ir.Member(name=kind.name, entity_type=ir.EntityType("cell", (kind.name,)))
        for block in kind.blocks:
            if closes_paths(block):
                yield ir.Domain(var=cell, where=block.condition, origin=block.origin)


def _agents_scope(on: ir.Member | None, w: Writer) -> IterationScope:
    """Returns a scope with one axis, of agents, in which `agent` is bound.

    on: the cell under each, of these kinds, under a name; those elsewhere are masked.
    """
    axis = w.axis("agent", w.module.agents)
    agent = AgentVar(iota(axis), axis)
    scope = IterationScope(axes=(axis,), variables={"agent": agent})
    if on is None:
        return scope
    site, is_on = state_reads.site_under(agent, on.kinds, w)
    return scope.binding(on.name, CellVar(site, on.kinds)).when(is_on)


def _write_members(
    domain: ir.Domain, on: ir.Member | None, module: Module, w: Writer
) -> np.ndarray | None:
    """Writes the body of `Cells.read`; returns `Cells.numbers`. on: the cell underfoot."""
    outer = _agents_scope(on, w)
    inner = enter(domain, outer, w)
    added = tuple(axis for axis in inner.axes if axis not in outer.axes)
    if len(added) > 1:
        raise NotSupported("a domain of several axes in a policy", domain.origin)
    member = inner.variables[domain.var.name]
    is_of_kinds = isinstance(member, CellVar) and member.axis is not None
    values = [inner.mask]
    if not is_of_kinds:
        values.append(_map_cells(member, module, w))
    differs = any(axis in value.axes for value in values for axis in outer.axes)
    axes = (*outer.axes, *added) if differs else added
    shape = (module.num_agents if differs else 1, -1)
    # The function, as a value without axes may be a plain number, which has no method `reshape`.
    w.give_back(*(call("jnp.reshape", spread(value, axes), shape) for value in values))
    if not is_of_kinds:
        return None
    rows = module.game.rows
    cells = geometry.cells_of(rows, 0, module.layout.glyphs(domain.var.kinds))
    return geometry.site_numbers(rows, 0, cells)


def _map_cells(member: AgentVar | CellVar, module: Module, w: Writer) -> Value:
    """Returns the cell of a member, `row * width + column` of the map."""
    layout = module.layout
    padded = state_reads.location(member, w)
    row = padded // layout.cols - layout.pad
    col = padded % layout.cols - layout.pad
    return row * layout.width + col


def namespace(module: Module) -> dict[str, Any]:
    """Returns the names that functions of a module use: kernels, its constants and its numbers."""
    names: dict[str, Any] = {"jnp": jnp}
    for module_name, kernels in KERNELS.items():
        names |= {kernel: getattr(import_module(module_name), kernel) for kernel in kernels}
    names |= {"NUM_AGENTS": module.num_agents, "MAP": module.game.rows, "PAD": module.layout.pad}
    exec("\n".join(f"{c.name} = {text(c.value)}" for c in module.constants.values()), names)
    return names | {n.name: n.value for n in module.numbers.values()}

"""Lowers which cells of a destination are free, and which of them fit which agent."""

from collections.abc import Iterable
from dataclasses import replace
from functools import reduce
from operator import or_

from sjdsl.compiler import ir
from sjdsl.compiler.ir.names import attribute_of
from sjdsl.compiler.ir.queries import body_types
from sjdsl.compiler.lower import state_reads
from sjdsl.compiler.lower.axes import (
    TRUE,
    Axis,
    Value,
    iota,
)
from sjdsl.compiler.lower.pools import Pool
from sjdsl.compiler.lower.scope import CellVar, IterationScope
from sjdsl.compiler.lower.writer import Writer
from sjdsl.compiler.program.expressions import Expression, Literal, Name, Where, call, concatenated


def fitting_cells(s: ir.Send, axis: Axis, scope: IterationScope, w: Writer) -> Value:
    """Returns which cells of a destination its `where` allows.

    axis: of the cells. The result may also differ along the axes of the scope's variables.
    """
    assert s.domain.where is not None
    cell = CellVar(iota(axis), s.domain.var.kinds, axis)
    inner = scope.binding(s.domain.var.name, cell)
    return w.value(s.domain.where, replace(inner, axes=(*scope.axes, axis)))


def free_cells(
    pool: Pool,
    leaving: Expression | None,
    same_for_all: bool,
    w: Writer,
    entered: Iterable[tuple[Pool, Name]] = (),
) -> Expression:
    """Returns which cells of a pool's destination are free, `[S]` bool, or None if all are.

    Args:
      leaving: whose cells count as free, `[N]` bool; None: nobody's.
      same_for_all: whether the same cells fit everybody; the others then are not free.
      entered: the pools of this phase before this one, each with who was placed there, `[N]` bool.
    """
    extent = w.module.num_cells(pool.kinds)
    axis = w.axis("destination", extent)
    free = TRUE

    def without_sites(name: str, sites: Expression) -> Value:
        """Returns which cells are not among some sites. name: of the sites in generated code."""
        taken = call("occupied", w.keep_node(name, sites, "i32"), extent)
        return Value(~taken, "bool", (axis,))

    if pool.phase != "start":  # before it, nobody is on the map
        free = without_sites("others", _sites_of_others(pool, leaving, w))
    placed: dict[ir.EntityType, list[Expression]] = {}
    for other, who in entered:
        if set(other.kinds) & set(pool.kinds):
            placed.setdefault(other.entity_type, []).append(who)
    for entity_type, masks in placed.items():
        positions = w.current(attribute_of("position", entity_type))
        cells = Where(reduce(or_, masks), positions, state_reads.nowhere(w).node)
        sites = state_reads.site_at(Value(cells, "i32"), pool.kinds, w)
        free = free & without_sites("entered", sites.node)
    if pool.send.domain.where is not None and same_for_all:
        free = free & fitting_cells(pool.send, axis, IterationScope(), w)
    if free == TRUE:
        return Literal(None)
    if not free.axes:
        return call("jnp.full", extent, free.node)
    return w.keep("free", free).node


def _sites_of_others(pool: Pool, leaving: Expression | None, w: Writer) -> Expression:
    """Returns the sites of a destination under all agents and movers, past the end if none.

    Those of the type that is sent come first.
    """
    sites: list[Expression] = []
    others = [other for other in body_types(w.game) if other != pool.entity_type]
    for entity_type in (pool.entity_type, *others):
        site, _ = state_reads.site_under(state_reads.everybody(w, entity_type), pool.kinds, w)
        if leaving is None or entity_type != pool.entity_type:
            sites.append(site.node)
        else:
            sites.append(Where(leaving, w.module.num_cells(pool.kinds), site.node))
    return concatenated(sites)

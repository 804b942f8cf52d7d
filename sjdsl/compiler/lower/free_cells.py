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
from sjdsl.compiler.program.expressions import Expression, Literal, Name, Where, call


def fitting_cells(s: ir.Send, axis: Axis, scope: IterationScope, w: Writer) -> Value:
    """Returns where a destination's `where` holds.

    It has the axis of the cells, and those of the variables that the condition names.
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
    """Returns which cells of a destination are free, `[S]` bool.

    leaving: whose cells count as free, `[N]` bool. same_for_all: whether the same cells fit
    everybody, so that those that fit nobody aren't free. entered: who has been placed before in
    this phase, by pool, `[N]` bool each.
    """
    extent = w.module.num_cells(pool.kinds)
    axis = w.axis("destination", extent)
    free = TRUE

    def empty(name: str, sites: Expression) -> Value:
        """Returns which cells are not among those that others stand on."""
        taken = call("occupied", w.keep_node(name, sites, "i32"), extent)
        return Value(~taken, "bool", (axis,))

    if pool.phase != "start":
        free = empty("others", _sites_of_others(pool, leaving, w))
    placed: dict[ir.EntityType, list[Expression]] = {}
    for other, who in entered:
        if set(other.kinds) & set(pool.kinds):
            placed.setdefault(other.entity_type, []).append(who)
    for entity_type, masks in placed.items():
        positions = w.current(attribute_of("position", entity_type))
        cells = Where(reduce(or_, masks), positions, state_reads.nowhere(w).node)
        sites = state_reads.site_at(Value(cells, "i32"), pool.kinds, w)
        free = free & empty("entered", sites.node)
    if pool.send.domain.where is not None and same_for_all:
        free = free & fitting_cells(pool.send, axis, IterationScope(), w)
    if free == TRUE:
        return Literal(None)  # all of them
    if not free.axes:
        return call("jnp.full", extent, free.node)
    return w.keep("free", free).node


def _sites_of_others(pool: Pool, leaving: Expression | None, w: Writer) -> Expression:
    """Returns which cells of a destination agents and movers stand on, those of its type first."""
    sites: list[Expression] = []
    for entity_type in sorted(
        body_types(w.module.game), key=lambda entity_type: entity_type != pool.entity_type
    ):
        site, _ = state_reads.site_under(state_reads.everybody(w, entity_type), pool.kinds, w)
        if leaving is None or entity_type != pool.entity_type:
            sites.append(site.node)
        else:
            sites.append(Where(leaving, w.module.num_cells(pool.kinds), site.node))
    if len(sites) == 1:
        return sites[0]
    return call("jnp.concatenate", sites)

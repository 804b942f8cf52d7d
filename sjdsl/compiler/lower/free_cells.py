"""Lowers which cells of a destination are free, and which of them fit whom."""

from collections.abc import Iterable
from dataclasses import replace

from sjdsl.compiler import ir
from sjdsl.compiler.ir.names import attribute_of
from sjdsl.compiler.ir.queries import body_sorts
from sjdsl.compiler.lower import state_reads
from sjdsl.compiler.lower.axes import (
    TRUE,
    Axis,
    Value,
    both,
    iota,
)
from sjdsl.compiler.lower.per_agent import any_of
from sjdsl.compiler.lower.pools import Pool
from sjdsl.compiler.lower.scope import CellVar, IterationScope
from sjdsl.compiler.lower.writer import Writer
from sjdsl.compiler.program import expressions as array


def fitting_cells(s: ir.Send, axis: Axis, scope: IterationScope, w: Writer) -> Value:
    """Returns where a destination's `where` holds, along the axis of its cells and those of the variables it names."""
    assert s.domain.where is not None
    variable = CellVar(iota(axis), s.domain.var.kinds, axis)
    return w.value(
        s.domain.where,
        replace(scope.binding(**{s.domain.var.name: variable}), axes=(*scope.axes, axis)),
    )


def free_cells(
    pool: Pool,
    leaving: array.Expression | None,
    alike: bool,
    w: Writer,
    entered: Iterable[tuple[Pool, array.Name]] = (),
) -> array.Expression:
    """Returns which cells of a destination are free, `[S]` bool. `alike`: the same ones fit everybody; `leaving`, `entered`: as of `place`."""
    extent = w.module.num_cells(pool.kinds)
    axis = w.axis("destination", extent)
    free = TRUE

    def without(name: str, sites: array.Expression) -> Value:
        taken = array.call("occupied", w.keep(name, Value(sites, "i32")).node, extent)
        return both(free, Value(array.Unary("~", taken), "bool", (axis,)))

    if pool.phase != "start":
        found: list[array.Expression] = []
        for sort in sorted(body_sorts(w.module.game), key=lambda sort: sort != pool.sort):
            site, _ = state_reads.site_under(state_reads.everybody(w, sort), pool.kinds, w)
            stays = leaving is None or sort != pool.sort
            found.append(
                site.node
                if stays
                else array.Where(leaving, w.module.num_cells(pool.kinds), site.node)
            )  # type: ignore[arg-type]
        free = without(
            "others",
            found[0]
            if len(found) == 1
            else array.call("jnp.concatenate", array.Sequence(tuple(found), is_list=True)),
        )
    newly_there = [
        (other.sort, who) for other, who in entered if set(other.kinds) & set(pool.kinds)
    ]
    for sort in dict.fromkeys(sort for sort, _ in newly_there):
        who: list[array.Expression] = [one for other, one in newly_there if other == sort]
        newly = array.Where(
            any_of(who), w.current(attribute_of("position", sort)), state_reads.nowhere(w).node
        )
        free = without("entered", state_reads.site_at(Value(newly, "i32"), pool.kinds, w).node)
    if pool.send.domain.where is not None and alike:
        free = both(free, fitting_cells(pool.send, axis, IterationScope(), w))
    return w.keep("free", free).node if free.axes else array.call("jnp.full", extent, free.node)

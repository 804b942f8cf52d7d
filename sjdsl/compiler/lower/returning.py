"""Lowers the return of those who were sent away for some steps, which is part of `tick`."""

from sjdsl.compiler import ir
from sjdsl.compiler.ir.free_variables import variables_around
from sjdsl.compiler.ir.names import attribute_of
from sjdsl.compiler.lower import state_reads
from sjdsl.compiler.lower.axes import (
    Value,
    iota,
    spread,
)
from sjdsl.compiler.lower.draws import KEY
from sjdsl.compiler.lower.free_cells import fitting_cells, free_cells
from sjdsl.compiler.lower.pools import Pool, sends_of
from sjdsl.compiler.lower.scope import AgentVar, IterationScope
from sjdsl.compiler.lower.writer import Writer, replaced
from sjdsl.compiler.program import expressions as array


def bring_back(pools: dict[str, tuple[Pool, ...]], sorts: list[ir.Sort], w: Writer) -> None:
    """Writes the part of `tick` in which respawn delays count down and those return whose delay is over.

    They return pool by pool, each on the map as it then is. sorts: of those who can be sent away.
    """
    due: dict[ir.Sort, array.Expression] = {}
    left: dict[str, array.Expression] = {}
    for sort in sorts:
        away = array.path(f"state.{attribute_of('away', sort)}")
        is_nowhere = array.Binary("==", state_reads.positions(w, sort), state_reads.nowhere(w).node)
        due[sort] = w.bind(
            "due", array.Binary("&", is_nowhere, array.Binary("==", away, array.Literal(1)))
        )
        waiting = array.Cast(
            array.Binary("&", is_nowhere, array.Binary(">", away, array.Literal(1))), "i32"
        )
        left[attribute_of("away", sort)] = array.Binary("-", away, waiting)
    w.set(array.Name("state"), replaced("state", left))
    for pool in (p for phase in pools.values() for p in phase):
        if any(s.after is not None for s in sends_of(pool, w.module)):
            w.forget()
            w.origin = pool.send.origin
            position, heading, away, away_facing, away_pool = (
                array.path(f"state.{attribute_of(name, pool.sort)}")
                for name in ("position", "heading", "away", "away_facing", "away_pool")
            )
            to_pool = array.Binary("==", away_pool, array.Literal(pool.number))
            back = w.keep("back", Value(array.Binary("&", due[pool.sort], to_pool), "bool")).node
            own = _of_those_who_return(pool, w)
            free = free_cells(pool, None, own is None, w)
            number = w.module.extent(pool.sort)
            drawn = (
                array.call("random_bits", KEY, w.stream(s ^ ir.RETURN), number)
                for s in (pool.send.cell_stream, pool.send.heading_stream)
            )
            among = (
                state_reads.cells_of(pool.kinds, w),
                free,
                back,
                *drawn,
                position,
                heading,
                away_facing,
            )
            attributes = [attribute_of(name, pool.sort) for name in ("position", "heading", "away")]
            new_position, new_heading, placed = (
                array.Name(w.names.fresh(name)) for name in (*attributes[:2], "placed")
            )
            w.unpack(
                (new_position, new_heading, placed),
                array.call("come_back", *among, *(() if own is None else (own,))),
            )
            new = (new_position, new_heading, array.Where(placed, array.Literal(0), away))
            w.set(array.Name("state"), replaced("state", dict(zip(attributes, new, strict=True))))
    w.forget()
    w.origin = None


def _of_those_who_return(pool: Pool, w: Writer) -> array.Expression | None:
    """Returns which cells fit each agent when it comes back, `[N, S]` bool; None if they are the same for all."""
    s = next(s for s in sends_of(pool, w.module) if s.after is not None)
    named = variables_around(s.domain)
    if not named:
        return None
    agents = w.axis(pool.sort.name, w.module.extent(pool.sort))
    axis = w.axis("destination", w.module.num_cells(s.domain.var.kinds))
    everybody = AgentVar(iota(agents), agents, pool.sort)
    scope = IterationScope(
        axes=(agents,), variables={variable.name: everybody for variable in named}
    )
    return w.keep(
        "fitting", Value(spread(fitting_cells(s, axis, scope, w), (agents, axis)), "bool")
    ).node

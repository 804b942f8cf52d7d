"""Lowers the return of those who were sent away for some ticks, a part of `tick`."""

from sjdsl.compiler import ir
from sjdsl.compiler.ir.free_variables import variables_around
from sjdsl.compiler.ir.names import attribute_of
from sjdsl.compiler.lower import state_reads
from sjdsl.compiler.lower.axes import (
    iota,
    spread,
)
from sjdsl.compiler.lower.draws import KEY
from sjdsl.compiler.lower.free_cells import fitting_cells, free_cells
from sjdsl.compiler.lower.pools import Pool, Pools, sends_of
from sjdsl.compiler.lower.scope import AgentVar, IterationScope, Variable
from sjdsl.compiler.lower.writer import Writer, replaced
from sjdsl.compiler.program.expressions import Cast, Expression, Literal, Name, Where, call, path


def bring_back(pools: Pools, sorts: list[ir.Sort], w: Writer) -> None:
    """Writes how delays count down, and how those come back whose delay is over.

    They come back pool by pool, each onto the map as it then is. sorts: of those who can be away.
    """
    due = _count_down(sorts, w)
    for pool in (p for of_phase in pools.values() for p in of_phase):
        if any(s.after is not None for s in sends_of(pool, w.module)):
            w.forget()
            w.origin = pool.send.origin
            _bring_back_to(pool, due[pool.sort], w)
    w.forget()
    w.origin = None


def _count_down(sorts: list[ir.Sort], w: Writer) -> dict[ir.Sort, Expression]:
    """Writes the ticks that everybody is still away; returns who is due, `[N]` bool."""
    due: dict[ir.Sort, Expression] = {}
    left: dict[str, Expression] = {}
    one = Literal(1)
    for sort in sorts:
        attribute = attribute_of("away", sort)
        away = path(f"state.{attribute}")
        is_nowhere = state_reads.positions(w, sort).eq(state_reads.nowhere(w).node)
        is_due = is_nowhere & away.eq(one)
        is_waiting = is_nowhere & (away > one)
        due[sort] = w.bind("due", is_due)
        left[attribute] = away - Cast(is_waiting, "i32")
    w.set(Name("state"), replaced("state", left))
    return due


def _bring_back_to(pool: Pool, due: Expression, w: Writer) -> None:
    """Writes how those come back who are due and were sent to a pool."""
    position, heading, away, away_facing, away_pool = (
        attribute_of(name, pool.sort)
        for name in ("position", "heading", "away", "away_facing", "away_pool")
    )

    def stored(attribute: str) -> Expression:
        return path(f"state.{attribute}")

    to_pool = stored(away_pool).eq(pool.number)
    back = w.keep_node("back", due & to_pool, "bool")
    fitting = _fitting_on_return(pool, w)
    free = free_cells(pool, None, fitting is None, w)
    arguments = [state_reads.cells_of(pool.kinds, w), free, back]
    for stream in (pool.send.cell_stream, pool.send.heading_stream):
        number = w.stream(stream ^ ir.RETURN)
        arguments.append(call("random_bits", KEY, number, w.module.extent(pool.sort)))
    arguments += [stored(position), stored(heading), stored(away_facing)]
    if fitting is not None:
        arguments.append(fitting)
    new_position = Name(w.names.fresh(position))
    new_heading = Name(w.names.fresh(heading))
    placed = Name(w.names.fresh("placed"))
    w.unpack((new_position, new_heading, placed), call("come_back", *arguments))
    changes: dict[str, Expression] = {
        position: new_position,
        heading: new_heading,
        away: Where(placed, Literal(0), stored(away)),
    }
    w.set(Name("state"), replaced("state", changes))


def _fitting_on_return(pool: Pool, w: Writer) -> Expression | None:
    """Returns which cells fit each agent when it comes back, `[N, S]` bool.

    None if the same fit all.
    """
    s = next(s for s in sends_of(pool, w.module) if s.after is not None)
    named = variables_around(s.domain)
    if not named:
        return None
    agents = w.axis(pool.sort.name, w.module.extent(pool.sort))
    axis = w.axis("destination", w.module.num_cells(s.domain.var.kinds))
    everybody = AgentVar(iota(agents), agents, pool.sort)
    variables: dict[str, Variable] = {variable.name: everybody for variable in named}
    scope = IterationScope(axes=(agents,), variables=variables)
    fits = spread(fitting_cells(s, axis, scope, w), (agents, axis))
    return w.keep_node("fitting", fits, "bool")

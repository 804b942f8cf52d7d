"""Lowers the return of those who were sent away for some ticks, which is a part of `tick`.

The state stores of each agent that is away the ticks that are left, the pool it was sent to, and
the heading that it will have.
"""

from sjdsl.compiler import ir
from sjdsl.compiler.ir.free_variables import variables_around
from sjdsl.compiler.ir.names import attribute_of
from sjdsl.compiler.lower import state_reads
from sjdsl.compiler.lower.axes import (
    iota,
    spread,
)
from sjdsl.compiler.lower.draws import bits_of_each
from sjdsl.compiler.lower.free_cells import fitting_cells, free_cells
from sjdsl.compiler.lower.pools import Pool, Pools, sends_of
from sjdsl.compiler.lower.scope import AgentVar, IterationScope, Variable
from sjdsl.compiler.lower.writer import Writer, replaced
from sjdsl.compiler.program.expressions import Cast, Expression, Literal, Name, Where, call, path


def bring_back(pools: Pools, entity_types: list[ir.EntityType], w: Writer) -> None:
    """Writes that delays count down, and that those come back whose delay is over.

    They come back pool by pool: those of the first pool are on the map before those of the next.

    entity_types: of those who can be away.
    """
    due = _count_down(entity_types, w)
    for pools_of_phase in pools.values():
        for pool in pools_of_phase:
            if any(s.after is not None for s in sends_of(pool, w.module)):
                w.forget()
                w.origin = pool.send.origin
                _bring_back_to(pool, due[pool.entity_type], w)
    w.forget()
    w.origin = None


def _count_down(entity_types: list[ir.EntityType], w: Writer) -> dict[ir.EntityType, Expression]:
    """Writes that everybody's delay falls by one; returns who is due now, `[N]` bool, by type."""
    due: dict[ir.EntityType, Expression] = {}
    left: dict[str, Expression] = {}  # ticks, by attribute of State
    for entity_type in entity_types:
        attribute = attribute_of("away", entity_type)
        away = path(f"state.{attribute}")
        is_nowhere = state_reads.positions(w, entity_type).eq(state_reads.nowhere(w).node)
        due[entity_type] = w.bind("due", is_nowhere & away.eq(1))
        left[attribute] = away - Cast(is_nowhere & (away > 1), "i32")
    w.set(Name("state"), replaced("state", left))
    return due


def _bring_back_to(pool: Pool, due: Expression, w: Writer) -> None:
    """Writes the new cells and headings of those who are due and were sent to a pool."""
    entity_type = pool.entity_type
    send = pool.send

    def stored(name: str) -> Expression:
        return path(f"state.{attribute_of(name, entity_type)}")

    back = w.keep_node("back", due & stored("away_pool").eq(pool.number), "bool")
    fitting = _fitting_on_return(pool, w)
    free = free_cells(pool, None, fitting is None, w)
    cells = state_reads.cells_of(pool.kinds, w)
    cell_bits = bits_of_each(send.cell_stream ^ ir.RETURN, entity_type, w)
    heading_bits = bits_of_each(send.heading_stream ^ ir.RETURN, entity_type, w)
    before = (stored("position"), stored("heading"), stored("away_facing"))
    arguments = [cells, free, back, cell_bits, heading_bits, *before]
    if fitting is not None:
        arguments.append(fitting)
    position = attribute_of("position", entity_type)
    heading = attribute_of("heading", entity_type)
    names = (position, heading, "placed")
    changes: dict[str, Expression] = {}
    changes[position], changes[heading], placed = w.keep_parts(names, call("come_back", *arguments))
    changes[attribute_of("away", entity_type)] = Where(placed, Literal(0), stored("away"))
    w.set(Name("state"), replaced("state", changes))


def _fitting_on_return(pool: Pool, w: Writer) -> Expression | None:
    """Returns which cells fit each agent when it comes back, `[N, S]` bool.

    None if the same fit all.
    """
    s = next(s for s in sends_of(pool, w.module) if s.after is not None)
    named = variables_around(s.domain)  # all are the agent that comes back
    if not named:
        return None
    agents = w.axis(pool.entity_type.name, w.module.extent(pool.entity_type))
    axis = w.axis("destination", w.module.num_cells(s.domain.var.kinds))
    everybody = AgentVar(iota(agents), agents, pool.entity_type)
    variables: dict[str, Variable] = {variable.name: everybody for variable in named}
    scope = IterationScope(axes=(agents,), variables=variables)
    fits = spread(fitting_cells(s, axis, scope, w), (agents, axis))
    return w.keep_node("fitting", fits, "bool")

"""Lowers `send` and `remove`: collects who is sent over the phase, then places them on free cells or takes them off the map."""

from dataclasses import dataclass, field

from sjdsl.compiler import ir
from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.ir.free_variables import variables_around
from sjdsl.compiler.ir.names import attribute_of
from sjdsl.compiler.ir.queries import body_sort
from sjdsl.compiler.lower import state_reads
from sjdsl.compiler.lower.axes import (
    Value,
    as_dtype,
    both,
    reduce,
    select,
    spread,
    union,
)
from sjdsl.compiler.lower.draws import KEY
from sjdsl.compiler.lower.expressions import agent
from sjdsl.compiler.lower.free_cells import fitting_cells, free_cells
from sjdsl.compiler.lower.per_agent import any_of, of_each, per_agent, put, turn
from sjdsl.compiler.lower.pools import Pool, sends_of
from sjdsl.compiler.lower.scope import IterationScope
from sjdsl.compiler.lower.shifting import Shifted, settle, shifted
from sjdsl.compiler.lower.writer import Writer
from sjdsl.compiler.program import expressions as array
from sjdsl.runtime.actions import ANY_HEADING, HEADINGS, SAME_HEADING


class Sent(Record):
    """Who goes at once by one statement. `own`: which cells fit each agent, `[N, S]` bool; None where they are the same for all."""

    send: ir.Send
    who: array.Expression
    own: array.Expression | None


class Leaving(Record):
    """Who goes away by one statement, and for how many ticks."""

    pool: Pool
    send: ir.Send
    who: array.Expression
    delays: array.Expression


@dataclass
class Sends:
    """The sends of one phase: for each pool who goes at once, and who goes away first."""

    pools: tuple[Pool, ...]
    now: dict[int, list[Sent]] = field(default_factory=dict)
    away: list[Leaving] = field(default_factory=list)
    removed: list[tuple[ir.Sort, array.Expression]] = field(default_factory=list)
    shifted: list[Shifted] = field(default_factory=list)

    def add(self, s: ir.Send, scope: IterationScope, w: Writer) -> None:
        """Notes who is sent, `[N]` bool (of movers, as many as there are of the sort)."""
        sent = w.keep("sent", per_agent(s.who, scope, w)).node
        pool = next(p for p in self.pools if p.send.pool == s.pool)
        own = _own_cells(s, scope, w) if s.after is None or s.after.type.low <= 0 else None
        if s.after is None:
            self.now.setdefault(pool.number, []).append(Sent(s, sent, own))
            return
        delays = _delays(s, as_dtype(w.value(s.after, scope.always()), "i32"), scope, w)
        if s.after.type.low <= 0:
            at_once = w.keep(
                "at_once",
                Value(
                    array.Binary("&", sent, array.Binary("==", delays, array.Literal(0))), "bool"
                ),
            ).node
            self.now.setdefault(pool.number, []).append(Sent(s, at_once, own))
            sent = w.keep(
                "leaving",
                Value(array.Binary("&", sent, array.Binary(">", delays, array.Literal(0))), "bool"),
            ).node
        self.away.append(Leaving(pool, s, sent, delays))

    def shift(self, s: ir.Shift, scope: IterationScope, w: Writer) -> None:
        """Notes who is sent some cells away, and where to."""
        self.shifted.append(shifted(s, scope, w))

    def remove(self, s: ir.Remove, scope: IterationScope, w: Writer) -> None:
        self.removed.append((body_sort(s.who), w.keep("removed", per_agent(s.who, scope, w)).node))


def _own_cells(s: ir.Send, scope: IterationScope, w: Writer) -> array.Expression | None:
    """Returns which cells of the destination fit each agent that the statement sends, `[N, S]` bool; None if that is the same for all."""
    if not variables_around(s.domain):
        return None
    axis = w.axis("destination", w.module.num_cells(s.domain.var.kinds))
    fits = fitting_cells(s, axis, scope.always(), w)
    who = agent(s.who, scope, w)
    if who.axis is not None:
        gone = tuple(a for a in scope.axes if a != who.axis)
        if any(
            a in fits.axes for a in gone
        ):  # of those who send the agent, all say the same: any of them
            fits = reduce("any", both(scope.mask, fits), gone)
        return w.keep("fitting", Value(spread(fits, (who.axis, axis)), "bool")).node
    axes = union(who.index.axes, scope.mask.axes, tuple(a for a in fits.axes if a != axis))
    extent = w.module.extent(who.sort)
    at = w.keep(
        f"to_{who.sort.name}",
        Value(spread(select(scope.mask, who.index, Value(extent, "i32")), axes), "i32"),
    )
    rows = spread(fits, (*axes, axis))
    table = array.call("jnp.zeros", array.Sequence((extent, axis.extent)), array.Name("bool"))
    return w.keep(
        "fitting", Value(array.Update(table, (at.node,), "set", rows, drop=True), "bool")
    ).node


def _delays(s: ir.Send, delay: Value, scope: IterationScope, w: Writer) -> array.Expression:
    """Returns the ticks each agent is away, `[N]` int32 or a number (all sends that reach one agent agree)."""
    if delay.literal and s.after is not None and s.after.type.low > 0:
        return delay.node
    if not delay.axes:
        return w.keep(
            "delay", Value(array.scalar(delay.node, "i32") if delay.literal else delay.node, "i32")
        ).node
    return w.keep("delay", Value(of_each(s.who, delay, scope, w), "i32")).node


def finish(sends: Sends, w: Writer) -> None:
    """Writes the placing of all who are sent in a phase."""
    earlier: list[tuple[Pool, array.Name]] = []
    for pool in sends.pools:
        parts = sends.now.get(pool.number, [])
        if not parts:
            continue
        w.origin = parts[0].send.origin
        sent = w.keep("sent", Value(any_of([part.who for part in parts]), "bool")).node
        left = None
        if not any(s.stay for s in sends_of(pool, w.module)):
            left = any_of([sent, *(leaving.who for leaving in sends.away if leaving.pool is pool)])
        own = parts[0].own
        if own is not None and len(parts) > 1:
            rows = (
                (array.Index(part.who, (array.ALL, array.NEW_AXIS)), part.own)
                for part in parts
                if part.own is not None
            )
            own = any_of([array.Binary("&", sent_here, fitting) for sent_here, fitting in rows])
        placed = place(pool, sent, left, own, w, earlier)
        earlier.append((pool, placed))
        for part in parts:
            who = placed if len(parts) == 1 else array.Binary("&", part.who, placed)
            turn(pool.sort, who, part.send.facing, pool.send.heading_stream, w)
        if w.module.stores_away(pool.sort):
            put("away", pool.sort, placed, array.Literal(0), w)
    for leaving in sends.away:
        w.origin, sort = leaving.send.origin, leaving.pool.sort
        put("position", sort, leaving.who, state_reads.nowhere(w).node, w)
        put("away", sort, leaving.who, leaving.delays, w)
        put("away_pool", sort, leaving.who, array.Literal(leaving.pool.number), w)
        put("away_facing", sort, leaving.who, _facing(leaving.send, w), w)
    w.origin = None
    for sort, removed in sends.removed:
        put("position", sort, removed, state_reads.nowhere(w).node, w)
        if w.module.stores_away(sort):
            put("away", sort, removed, array.Literal(0), w)
    if sends.shifted:
        settle(sends.shifted, w)


def _facing(s: ir.Send, w: Writer) -> array.Literal:
    """Returns the heading that an agent sent away will have."""
    match s.facing:
        case None:
            return w.module.number("any_heading", ANY_HEADING)
        case "same":
            return w.module.number("same_heading", SAME_HEADING)
        case heading:
            return w.module.number(heading, HEADINGS.index(heading))


def place(
    pool: Pool,
    sent: array.Expression,
    leaving: array.Expression | None,
    own: array.Expression | None,
    w: Writer,
    entered: list[tuple[Pool, array.Name]],
) -> array.Name:
    """Writes the placing of one pool; returns who found a cell. The cells of those who are `leaving` count as free.

    own: the cells that fit each agent, `[N, S]` bool; None where they are the same for all. entered: who has been placed before in this
    phase, by pool, `[N]` bool each.
    """
    attribute = attribute_of("position", pool.sort)
    free = free_cells(pool, leaving, own is None, w, entered)
    placed = array.Name(w.names.fresh("placed"))
    before = w.current(attribute)
    position = w.changed.get(attribute) or array.Name(w.names.fresh(attribute))
    assert isinstance(position, array.Name)
    w.changed[attribute] = position
    bits = array.call(
        "random_bits", KEY, w.stream(pool.send.cell_stream), w.module.extent(pool.sort)
    )
    among = (
        (state_reads.cells_of(pool.kinds, w), free)
        if own is None
        else (state_reads.cells_of(pool.kinds, w), free, own)
    )
    w.unpack(
        (position, placed),
        array.call("place" if own is None else "place_fitting", *among, bits, before, sent),
    )
    return placed

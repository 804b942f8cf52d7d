"""Lowers `send` and `remove`: collects who is sent in a phase, then places or removes them."""

import functools
from dataclasses import dataclass, field
from operator import or_

from sjdsl.compiler import ir
from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.ir.free_variables import variables_around
from sjdsl.compiler.ir.names import attribute_of
from sjdsl.compiler.ir.queries import body_type
from sjdsl.compiler.lower import state_reads
from sjdsl.compiler.lower.axes import (
    Value,
    as_dtype,
    common,
    reduce,
    spread,
    without,
)
from sjdsl.compiler.lower.draws import bits_of_each
from sjdsl.compiler.lower.expressions import agent
from sjdsl.compiler.lower.free_cells import fitting_cells, free_cells
from sjdsl.compiler.lower.per_agent import of_each, per_agent, put, scattered, turn, way_of_each
from sjdsl.compiler.lower.pools import Pool, sends_of
from sjdsl.compiler.lower.scope import IterationScope
from sjdsl.compiler.lower.shifting import Shifted, settle, shifted
from sjdsl.compiler.lower.writer import Writer
from sjdsl.compiler.program.expressions import (
    Expression,
    Literal,
    Name,
    call,
)
from sjdsl.runtime.actions import ANY_HEADING, HEADINGS, SAME_HEADING


class Sent(Record):
    """Whom one statement sends at once.

    who: `[N]` bool. fitting: which cells of the destination fit each agent, `[N, S]` bool; None if
    the same fit all. way: its heading afterwards, `[N]` int32, if the statement computes it.
    """

    send: ir.Send
    who: Expression
    fitting: Expression | None
    way: Expression | None


class Leaving(Record):
    """Whom one statement sends away for some ticks.

    who: `[N]` bool. delays: the ticks of each, `[N]` int32, or one number. way: as in `Sent`.
    """

    pool: Pool
    send: ir.Send
    who: Expression
    delays: Expression
    way: Expression | None


@dataclass
class Sends:
    """Whom the statements of a phase send, collected until its end.

    pools: the phase's destinations. now: by a pool's number, who is placed there at once. away: who
    goes away first. removed: who leaves the map, `[N]` bool. shifted: who is sent along a way.
    """

    pools: tuple[Pool, ...]
    now: dict[int, list[Sent]] = field(default_factory=dict)
    away: list[Leaving] = field(default_factory=list)
    removed: list[tuple[ir.EntityType, Expression]] = field(default_factory=list)
    shifted: list[Shifted] = field(default_factory=list)

    def add(self, s: ir.Send, scope: IterationScope, w: Writer) -> None:
        """Collects whom a `send x to DOMAIN` sends, now or after some ticks."""
        sent = per_agent("sent", s.who, scope, w)
        pool = next(p for p in self.pools if p.send.pool == s.pool)
        at_once = self.now.setdefault(pool.number, [])
        way = way_of_each(s.who, s.way, scope, w)
        if s.after is None:
            at_once.append(Sent(s, sent, _fitting(s, scope, w), way))
            return
        can_be_now = s.after.type.low <= 0
        fitting = _fitting(s, scope, w) if can_be_now else None
        delay = as_dtype(w.value(s.after, scope), "i32")
        delays = _delays(s, delay, scope, w)
        if can_be_now:
            sent_now = w.keep_node("at_once", sent & delays.eq(0), "bool")
            at_once.append(Sent(s, sent_now, fitting, way))
            sent = w.keep_node("leaving", sent & (delays > 0), "bool")
        self.away.append(Leaving(pool, s, sent, delays, way))

    def shift(self, s: ir.Shift, scope: IterationScope, w: Writer) -> None:
        """Collects whom a `send x by n DIRECTION` sends, or a `send x to CELL`."""
        self.shifted.append(shifted(s, scope, w))

    def remove(self, s: ir.Remove, scope: IterationScope, w: Writer) -> None:
        """Collects whom a `remove x` takes off the map."""
        removed = per_agent("removed", s.who, scope, w)
        self.removed.append((body_type(s.who), removed))


def _fitting(s: ir.Send, scope: IterationScope, w: Writer) -> Expression | None:
    """Returns which cells of the destination fit each agent that is sent, `[N, S]` bool.

    None if the same fit all.
    """
    if not variables_around(s.domain):
        return None
    axis = w.axis("destination", w.module.num_cells(s.domain.var.kinds))
    fits = fitting_cells(s, axis, scope.always(), w)
    who = agent(s.who, scope, w)
    if who.axis is not None:
        others = without(scope.axes, (who.axis,))
        if common(others, fits.axes):  # all who send the agent agree on its cells
            fits = reduce("any", scope.mask & fits, others)
        return w.keep_node("fitting", spread(fits, (who.axis, axis)), "bool")
    return w.keep_node("fitting", scattered(who, fits, scope, w, (axis,)), "bool")


def _delays(s: ir.Send, delay: Value, scope: IterationScope, w: Writer) -> Expression:
    """Returns the ticks that each agent is away, `[N]` int32, or one number for all."""
    if delay.literal and s.after is not None and s.after.type.low > 0:
        return delay.node
    if delay.axes:
        return w.keep_node("delay", of_each(s.who, delay, scope, w), "i32")
    number = delay.array.node
    return w.keep_node("delay", number, "i32")


def finish(sends: Sends, w: Writer) -> None:
    """Writes what becomes of all who are sent or removed in a phase."""
    entered: list[tuple[Pool, Name]] = []
    for pool in sends.pools:
        if sends.now.get(pool.number):
            placed = _place_pool(pool, sends, entered, w)
            entered.append((pool, placed))
    for leaving in sends.away:
        w.origin = leaving.send.origin
        entity_type = leaving.pool.entity_type
        put("position", entity_type, leaving.who, state_reads.nowhere(w).node, w)
        put("away", entity_type, leaving.who, leaving.delays, w)
        put("away_pool", entity_type, leaving.who, leaving.pool.number, w)
        facing = _facing(leaving.send, w) if leaving.way is None else leaving.way
        put("away_facing", entity_type, leaving.who, facing, w)
    w.origin = None
    for entity_type, removed in sends.removed:
        put("position", entity_type, removed, state_reads.nowhere(w).node, w)
        if w.module.stores_away(entity_type):
            put("away", entity_type, removed, 0, w)
    if sends.shifted:
        settle(sends.shifted, w)


def _facing(s: ir.Send, w: Writer) -> Literal:
    """Returns the heading that an agent sent away will have, as a number that the state stores."""
    match s.facing:
        case None:
            return w.module.number("any_heading", ANY_HEADING)
        case "same":
            return w.module.number("same_heading", SAME_HEADING)
        case heading:
            return w.module.number(heading, HEADINGS.index(heading))


def _place_pool(pool: Pool, sends: Sends, entered: list[tuple[Pool, Name]], w: Writer) -> Name:
    """Writes the new cells of those who are sent to a pool at once; returns who found one.

    entered: the pools of the phase before this one, each with who was placed there.
    """
    all_sent = sends.now[pool.number]
    w.origin = all_sent[0].send.origin
    sent = w.keep_node("sent", functools.reduce(or_, [part.who for part in all_sent]), "bool")
    leaving = None
    if not any(s.stay for s in sends_of(pool, w.module)):  # who may stay keeps its cell
        away = [other.who for other in sends.away if other.pool is pool]
        leaving = functools.reduce(or_, [sent, *away])
    placed = place(pool, sent, leaving, _fitting_of_all(all_sent), w, entered)
    for part in all_sent:
        who = placed if len(all_sent) == 1 else part.who & placed
        turn(pool.entity_type, who, part.send.facing, part.way, pool.send.heading_stream, w)
    if w.module.stores_away(pool.entity_type):
        put("away", pool.entity_type, placed, 0, w)
    return placed


def _fitting_of_all(parts: list[Sent]) -> Expression | None:
    """Returns which cells fit each agent, for all statements that send to a pool."""
    if len(parts) == 1 or parts[0].fitting is None:
        return parts[0].fitting
    fitting = [part.who[:, None] & part.fitting for part in parts if part.fitting is not None]
    return functools.reduce(or_, fitting)


def place(
    pool: Pool,
    sent: Expression,
    leaving: Expression | None,
    fitting: Expression | None,
    w: Writer,
    entered: list[tuple[Pool, Name]],
) -> Name:
    """Writes `position, placed = place(...)` for one pool; returns `placed`, who found a cell.

    Args:
      sent: who is to be placed, `[N]` bool.
      fitting: which cells fit each agent, `[N, S]` bool; None if the same fit all.
      leaving, entered: see `free_cells`.
    """
    attribute = attribute_of("position", pool.entity_type)
    free = free_cells(pool, leaving, fitting is None, w, entered)
    placed = w.fresh("placed")
    before = w.current(attribute)
    position = w.changed.get(attribute) or w.fresh(attribute)
    assert isinstance(position, Name)
    w.changed[attribute] = position
    bits = bits_of_each(pool.send.cell_stream, pool.entity_type, w)
    arguments = [state_reads.cells_of(pool.kinds, w), free, bits, before, sent]
    if fitting is not None:
        arguments.append(fitting)
    w.unpack((position, placed), call("place", *arguments))
    return placed

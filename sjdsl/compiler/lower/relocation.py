"""Lowers `send` and `remove`: collects who is sent over the phase, then spawns or respawns them on free cells."""

from dataclasses import dataclass, field, replace

from sjdsl.compiler import ir
from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.ir.free_variables import variables_around
from sjdsl.compiler.lower import state_reads
from sjdsl.compiler.lower.axes import TRUE, Axis, Value, as_dtype, both, iota, literal, reduce, select, spread, union
from sjdsl.compiler.lower.draws import KEY
from sjdsl.compiler.lower.expressions import owner
from sjdsl.compiler.lower.per_agent import per_agent, scattered
from sjdsl.compiler.lower.scope import AgentVar, CellVar, IterationScope
from sjdsl.compiler.lower.shifting import Shifted, settle, shifted
from sjdsl.compiler.lower.writer import Module, Writer, replaced
from sjdsl.compiler.program import expressions as array
from sjdsl.runtime.actions import HEADINGS

ANY_HEADING, SAME_HEADING = 4, 5  # of an agent that is away
AWAY = array.path("state.away")


class Pool(Record):
    """One destination of one phase use; `number` names it in the state of those who are away."""

    number: int
    send: ir.Send
    phase: str

    @property
    def kinds(self) -> tuple[str, ...]:
        return self.send.domain.var.kinds


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
    away_stored: bool = False
    now: dict[int, list[Sent]] = field(default_factory=dict)
    away: list[Leaving] = field(default_factory=list)
    removed: list[array.Expression] = field(default_factory=list)
    shifted: list[Shifted] = field(default_factory=list)

    def add(self, s: ir.Send, scope: IterationScope, w: Writer) -> None:
        """Notes who is sent, `[N]` bool."""
        sent = w.keep("sent", per_agent(s.who, scope, w)).node
        pool = next(p for p in self.pools if p.send.pool == s.pool)
        own = _own_cells(s, scope, w) if s.after is None or s.after.type.low <= 0 else None
        if s.after is None:
            self.now.setdefault(pool.number, []).append(Sent(s, sent, own))
            return
        delays = _delays(s, as_dtype(w.value(s.after, scope.always()), "i32"), scope, w)
        if s.after.type.low <= 0:
            at_once = w.keep("at_once", Value(array.Binary("&", sent, array.Binary("==", delays, array.Literal(0))), "bool")).node
            self.now.setdefault(pool.number, []).append(Sent(s, at_once, own))
            sent = w.keep("leaving", Value(array.Binary("&", sent, array.Binary(">", delays, array.Literal(0))), "bool")).node
        self.away.append(Leaving(pool, s, sent, delays))

    def shift(self, s: ir.Shift, scope: IterationScope, w: Writer) -> None:
        """Notes who is sent some cells away, and where to."""
        self.shifted.append(shifted(s, scope, w))

    def remove(self, s: ir.Remove, scope: IterationScope, w: Writer) -> None:
        self.removed.append(w.keep("removed", per_agent(s.who, scope, w)).node)


def _own_cells(s: ir.Send, scope: IterationScope, w: Writer) -> array.Expression | None:
    """Returns which cells of the destination fit each agent that the statement sends, `[N, S]` bool; None if that is the same for all."""
    if not variables_around(s.domain):
        return None
    axis = w.axis("destination", w.module.num_cells(s.domain.var.kinds))
    fits = _fits(s, axis, scope.always(), w)
    who = owner(s.who, scope, w)
    assert isinstance(who, AgentVar)
    if who.axis is not None:
        gone = tuple(a for a in scope.axes if a != who.axis)
        if any(a in fits.axes for a in gone):  # of those who send the agent, all say the same: any of them
            fits = reduce("any", both(scope.mask, fits) or TRUE, gone)
        return w.keep("fitting", Value(spread(fits, (who.axis, axis)), "bool")).node
    axes = union(who.index.axes, () if scope.mask is None else scope.mask.axes, tuple(a for a in fits.axes if a != axis))
    at = w.keep("to_agent", Value(spread(select(scope.mask, who.index, Value(w.module.agents, "i32")), axes), "i32"))
    rows = spread(fits, (*axes, axis))
    table = array.call("jnp.zeros", array.Sequence((w.module.agents, axis.extent)), array.Name("bool"))
    return w.keep("fitting", Value(array.Update(table, (at.node,), "set", rows, drop=True), "bool")).node


def _fits(s: ir.Send, axis: Axis, scope: IterationScope, w: Writer) -> Value:
    """Returns where a destination's `where` holds, along the axis of its cells and those of the variables it names."""
    assert s.domain.where is not None
    variable = CellVar(iota(axis), s.domain.var.kinds, axis)
    inner = replace(scope.binding(**{s.domain.var.name: variable}), axes=(*scope.axes, axis))
    return w.value(s.domain.where, inner)


def _delays(s: ir.Send, delay: Value, scope: IterationScope, w: Writer) -> array.Expression:
    """Returns the ticks each agent is away, `[N]` int32 or a number (all sends that reach one agent agree)."""
    if delay.literal and s.after is not None and s.after.type.low > 0:
        return delay.node
    if not delay.axes:
        return w.keep("delay", Value(array.scalar(delay.node, "i32") if delay.literal else delay.node, "i32")).node
    who = owner(s.who, scope, w)
    assert isinstance(who, AgentVar)
    if who.axis is not None:
        over = tuple(a for a in delay.axes if a != who.axis)
        if over:
            masked = select(scope.mask, delay, literal(0, "i32"))
            where = tuple(masked.axes.index(a) for a in over if a in masked.axes)
            delay = Value(array.Reduce("max", masked.node, where), "i32")
        return w.keep("delay", delay).node
    return w.keep("delay", Value(scattered(who, delay.node, "i32", scope, w), "i32")).node


def all_pools(game: ir.Game) -> dict[str, tuple[Pool, ...]]:
    """Returns the pools of every phase, numbered through the game."""
    pools: dict[str, tuple[Pool, ...]] = {}
    number = 0
    for phase in (game.start, *game.schedule):
        if not isinstance(phase, ir.Phase):
            continue
        found: dict[int, Pool] = {}
        for node in ir.walk(phase):
            if isinstance(node, ir.Send) and node.pool not in found:
                found[node.pool] = Pool(number, node, phase.name)
                number += 1
        pools[phase.name] = tuple(found.values())
    return pools


def finish(sends: Sends, w: Writer) -> None:
    """Writes the placing of all who are sent in a phase."""
    can_be_away = any(a.after is not None for p in sends.pools for a in _sends_of(p, w.module)) or sends.away_stored
    earlier: list[tuple[Pool, array.Expression]] = []
    for pool in sends.pools:
        parts = sends.now.get(pool.number, [])
        if not parts:
            continue
        w.origin = parts[0].send.origin
        sent = w.keep("sent", Value(_any_of([part.who for part in parts]), "bool")).node
        left = None
        if not any(s.stay for s in _sends_of(pool, w.module)):
            left = _any_of([sent, *(leaving.who for leaving in sends.away if leaving.pool is pool)])
        entered: list[array.Expression] = [who for p, who in earlier if set(p.kinds) & set(pool.kinds)]
        placed = place(pool, sent, left, _fitting(parts), w, entered=entered)
        earlier.append((pool, placed))
        _headings(pool, parts, placed, w)
        if can_be_away:
            _put("away", placed, array.Literal(0), w)
    for leaving in sends.away:
        w.origin = leaving.send.origin
        _put("position", leaving.who, state_reads.nowhere(w).node, w)
        _put("away", leaving.who, leaving.delays, w)
        _put("away_pool", leaving.who, array.Literal(leaving.pool.number), w)
        _put("away_facing", leaving.who, _facing(leaving.send, w), w)
    w.origin = None
    for removed in sends.removed:
        _put("position", removed, state_reads.nowhere(w).node, w)
        if sends.away_stored:
            _put("away", removed, array.Literal(0), w)
    if sends.shifted:
        settle(sends.shifted, w)


def _fitting(parts: list[Sent]) -> array.Expression | None:
    """Returns which cells fit each agent that a pool sends, `[N, S]` bool; None if they are the same for all."""
    if parts[0].own is None or len(parts) == 1:
        return parts[0].own
    rows = [array.Binary("&", array.Index(part.who, (array.ALL, array.NEW_AXIS)), part.own) for part in parts if part.own is not None]
    return _any_of(list(rows))


def _put(attribute: str, who: array.Expression, value: array.Expression, w: Writer) -> None:
    """Gives an attribute of some agents a new value."""
    w.assign(attribute, array.Where(who, value, w.current(attribute)))


def _any_of(who: list[array.Expression]) -> array.Expression:
    first, *rest = who
    for other in rest:
        first = array.Binary("|", first, other)
    return first


def _facing(s: ir.Send, w: Writer) -> array.Literal:
    """Returns the heading that an agent sent away will have."""
    if s.facing is None:
        return w.module.number("any_heading", ANY_HEADING)
    if s.facing == "same":
        return w.module.number("same_heading", SAME_HEADING)
    return heading_number(s.facing, w)


def heading_number(heading: str, w: Writer) -> array.Literal:
    return w.module.number(heading, HEADINGS.index(heading))


def _sends_of(pool: Pool, module: Module) -> list[ir.Send]:
    """Returns all statements that send to a pool."""
    return [s for s in module.sends if s.order_stream == pool.send.order_stream]


def place(
    pool: Pool,
    sent: array.Expression,
    leaving: array.Expression | None,
    own: array.Expression | None,
    w: Writer,
    stream_change: int = 0,
    entered: list[array.Expression] | None = None,
) -> array.Name:
    """Writes the placing of one pool; returns who found a cell. The cells of those who are `leaving` count as free.

    own: the cells that fit each agent, `[N, S]` bool; None where they are the same for all. entered: who has been placed on such cells
    before in this phase, `[N]` bool each.
    """
    kinds = pool.send.domain.var.kinds
    extent = w.module.num_cells(kinds)
    axis = w.axis("destination", extent)
    free: Value | None = None

    def without(name: str, sites: array.Expression) -> Value | None:
        taken = array.call("occupied", w.keep(name, Value(sites, "i32")).node, extent)
        return both(free, Value(array.Unary("~", taken), "bool", (axis,)))

    if pool.phase != "start":
        site, _ = state_reads.site_under(state_reads.everybody(w), kinds, w)
        free = without("others", site.node if leaving is None else array.Where(leaving, extent, site.node))
    if entered:
        newly = array.Where(_any_of(entered), w.current("position"), state_reads.nowhere(w).node)
        free = without("entered", state_reads.site_at(Value(newly, "i32"), kinds, w).node)
    if pool.send.domain.where is not None and own is None:
        free = both(free, _fits(pool.send, axis, IterationScope(), w))
    free = TRUE if free is None else free
    free = w.keep("free", free) if free.axes else Value(array.call("jnp.full", extent, free.node), "bool", (axis,))
    placed = array.Name(w.names.fresh("placed"))
    before = w.current("position")
    position = w.changed.get("position") or array.Name(w.names.fresh("position"))
    assert isinstance(position, array.Name)
    w.changed["position"] = position
    stream = w.stream(pool.send.order_stream ^ stream_change)
    bits = array.call("random_bits", KEY, stream, w.module.agents)
    cells = state_reads.cells_of(kinds, w)
    among = (cells, free.node) if own is None else (cells, free.node, own)
    w.unpack((position, placed), array.call("place" if own is None else "place_fitting", *among, bits, before, sent))
    return placed


def _any_heading(pool: Pool, w: Writer, stream_change: int = 0) -> array.Expression:
    """Returns a random heading for each agent."""
    stream = w.stream(pool.send.heading_stream ^ stream_change)
    return array.call("below", array.call("random_bits", KEY, stream, w.module.agents), array.Literal(4))


def _headings(pool: Pool, parts: list[Sent], placed: array.Name, w: Writer) -> None:
    for part in parts:
        facing = part.send.facing
        if facing == "same":
            continue
        who = placed if len(parts) == 1 else array.Binary("&", part.who, placed)
        _put("heading", who, _any_heading(pool, w) if facing is None else heading_number(facing, w), w)


def bring_back(pools: dict[str, tuple[Pool, ...]], w: Writer) -> None:
    """Writes the part of `tick` in which respawn delays count down and agents return whose delay is over: pool by pool, each on the map as it then is."""
    is_nowhere = array.Binary("==", array.path("state.position"), state_reads.nowhere(w).node)
    due = w.bind("due", array.Binary("&", is_nowhere, array.Binary("==", AWAY, array.Literal(1))))
    waiting = array.Cast(array.Binary("&", is_nowhere, array.Binary(">", AWAY, array.Literal(1))), "i32")
    w.set(array.Name("state"), replaced("state", {"away": array.Binary("-", AWAY, waiting)}))
    for pool in (p for phase in pools.values() for p in phase):
        if not any(s.after is not None for s in _sends_of(pool, w.module)):
            continue
        w.forget()
        w.origin = pool.send.origin
        to_pool = array.Binary("==", array.path("state.away_pool"), array.Literal(pool.number))
        back = w.keep("back", Value(array.Binary("&", due, to_pool), "bool")).node
        placed = place(pool, back, None, _of_those_who_return(pool, w), w, ir.RETURN)
        wanted, heading = array.path("state.away_facing"), array.path("state.heading")
        is_any = array.Binary("==", wanted, w.module.number("any_heading", ANY_HEADING))
        is_same = array.Binary("==", wanted, w.module.number("same_heading", SAME_HEADING))
        facing = w.bind("facing", array.Where(is_any, _any_heading(pool, w, ir.RETURN), wanted))
        w.set(facing, array.Where(is_same, heading, facing))
        w.assign("heading", array.Where(placed, facing, heading))
        w.assign("away", array.Where(placed, array.Literal(0), AWAY))
        w.set(array.Name("state"), replaced("state", w.changed))
        w.changed.clear()
    w.forget()
    w.origin = None


def _of_those_who_return(pool: Pool, w: Writer) -> array.Expression | None:
    """Returns which cells fit each agent when it comes back, `[N, S]` bool; None if they are the same for all."""
    s = next(s for s in _sends_of(pool, w.module) if s.after is not None)
    named = variables_around(s.domain)
    if not named:
        return None
    agents = w.axis("agent", w.module.agents)
    axis = w.axis("destination", w.module.num_cells(s.domain.var.kinds))
    everybody = AgentVar(iota(agents), agents)
    scope = IterationScope(axes=(agents,), variables={variable.name: everybody for variable in named})
    return w.keep("fitting", Value(spread(_fits(s, axis, scope, w), (agents, axis)), "bool")).node

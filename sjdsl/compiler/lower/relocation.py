"""Lowers `send` and `remove`: collects who is sent over the phase, then spawns or respawns them on free cells."""

from dataclasses import dataclass, field

from sjdsl.compiler import ir
from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.lower import state_reads
from sjdsl.compiler.lower.axes import TRUE, Value, as_dtype, both, iota, literal, reduce, select
from sjdsl.compiler.lower.draws import KEY
from sjdsl.compiler.lower.expressions import owner
from sjdsl.compiler.lower.scope import AgentVar, CellVar, IterationScope
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
    now: dict[int, list[tuple[ir.Send, array.Expression]]] = field(default_factory=dict)
    away: list[Leaving] = field(default_factory=list)
    removed: list[array.Expression] = field(default_factory=list)

    def add(self, s: ir.Send, scope: IterationScope, w: Writer) -> None:
        """Notes who is sent, `[N]` bool."""
        sent = w.keep("sent", _per_agent(s.who, scope, w)).node
        pool = next(p for p in self.pools if p.send.pool == s.pool)
        if s.after is None:
            self.now.setdefault(pool.number, []).append((s, sent))
            return
        delays = _delays(s, as_dtype(w.value(s.after, scope.always()), "i32"), scope, w)
        if s.after.type.low <= 0:
            at_once = w.keep("at_once", Value(array.Binary("&", sent, array.Binary("==", delays, array.Literal(0))), "bool")).node
            self.now.setdefault(pool.number, []).append((s, at_once))
            sent = w.keep("leaving", Value(array.Binary("&", sent, array.Binary(">", delays, array.Literal(0))), "bool")).node
        self.away.append(Leaving(pool, s, sent, delays))

    def remove(self, s: ir.Remove, scope: IterationScope, w: Writer) -> None:
        self.removed.append(w.keep("removed", _per_agent(s.who, scope, w)).node)


def _per_agent(e: ir.Expr, scope: IterationScope, w: Writer) -> Value:
    """Returns which agents a statement reaches, `[N]` bool."""
    who = owner(e, scope, w)
    assert isinstance(who, AgentVar)
    mask = scope.mask or TRUE
    if who.axis is not None:
        hit = reduce("any", mask, tuple(a for a in scope.axes if a != who.axis))
        return hit if hit.axes else Value(array.call("jnp.full", w.module.agents, hit.node), "bool")
    return Value(_scattered(who, array.Literal(True), "bool", scope, w), "bool")


def _scattered(who: AgentVar, value: array.Expression, dtype: str, scope: IterationScope, w: Writer) -> array.Expression:
    """Returns a value for each agent that some instance is about, `[N]`; 0 for the others."""
    at = w.keep("to_agent", select(scope.mask, who.index, Value(w.module.agents, "i32")))
    return array.Update(array.call("jnp.zeros", w.module.agents, array.DTYPES[dtype]), (at.node,), "set", value, drop=True)  # type: ignore[index]


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
    return w.keep("delay", Value(_scattered(who, delay.node, "i32", scope, w), "i32")).node


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
    for pool in sends.pools:
        parts = sends.now.get(pool.number, [])
        if not parts:
            continue
        w.origin = parts[0][0].origin
        sent = w.keep("sent", Value(_any_of([who for _, who in parts]), "bool")).node
        left = None
        if not any(s.stay for s in _sends_of(pool, w.module)):
            left = _any_of([sent, *(leaving.who for leaving in sends.away if leaving.pool is pool)])
        placed = place(pool, sent, left, w, 0)
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


def place(pool: Pool, sent: array.Expression, leaving: array.Expression | None, w: Writer, stream_change: int) -> array.Name:
    """Writes the placing of one pool; returns who found a cell. The cells of those who are `leaving` count as free."""
    kinds = pool.send.domain.var.kinds
    extent = w.module.num_cells(kinds)
    axis = w.axis("destination", extent)
    free: Value | None = None
    if pool.phase != "start":
        site, _ = state_reads.site_under(state_reads.everybody(w), kinds, w)
        others = Value(site.node if leaving is None else array.Where(leaving, extent, site.node), "i32")
        free = Value(array.Unary("~", array.call("occupied", w.keep("others", others).node, extent)), "bool", (axis,))
    if pool.send.domain.where is not None:
        variable = CellVar(iota(axis), kinds, axis)
        scope = IterationScope(axes=(axis,), variables={pool.send.domain.var.name: variable})
        free = both(free, w.value(pool.send.domain.where, scope))
    free = TRUE if free is None else free
    free = w.keep("free", free) if free.axes else Value(array.call("jnp.full", extent, free.node), "bool", (axis,))
    placed = array.Name(w.names.fresh("placed"))
    before = w.current("position")
    position = w.changed.get("position") or array.Name(w.names.fresh("position"))
    assert isinstance(position, array.Name)
    w.changed["position"] = position
    stream = w.stream(pool.send.order_stream ^ stream_change)
    bits = array.call("random_bits", KEY, stream, w.module.agents)
    w.unpack((position, placed), array.call("place", state_reads.cells_of(kinds, w), free.node, bits, before, sent))
    return placed


def _any_heading(pool: Pool, w: Writer, stream_change: int = 0) -> array.Expression:
    """Returns a random heading for each agent."""
    stream = w.stream(pool.send.heading_stream ^ stream_change)
    return array.call("below", array.call("random_bits", KEY, stream, w.module.agents), array.Literal(4))


def _headings(pool: Pool, parts: list[tuple[ir.Send, array.Expression]], placed: array.Name, w: Writer) -> None:
    for s, sent in parts:
        if s.facing == "same":
            continue
        who = placed if len(parts) == 1 else array.Binary("&", sent, placed)
        _put("heading", who, _any_heading(pool, w) if s.facing is None else heading_number(s.facing, w), w)


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
        placed = place(pool, back, None, w, ir.RETURN)
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

"""Lowers `send` and `remove`: collects who is sent over the phase, then spawns or respawns them on free cells."""

from collections.abc import Iterable
from dataclasses import dataclass, field, replace

from sjdsl.compiler import ir
from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.ir.free_variables import variables_around
from sjdsl.compiler.ir.names import attribute_of
from sjdsl.compiler.ir.queries import body_sort, body_sorts
from sjdsl.compiler.lower import state_reads
from sjdsl.compiler.lower.axes import TRUE, Axis, Value, as_dtype, both, iota, reduce, select, spread, union
from sjdsl.compiler.lower.draws import KEY
from sjdsl.compiler.lower.expressions import owner
from sjdsl.compiler.lower.per_agent import of_each, per_agent
from sjdsl.compiler.lower.scope import AgentVar, CellVar, IterationScope
from sjdsl.compiler.lower.shifting import Shifted, settle, shifted
from sjdsl.compiler.lower.writer import Module, Writer, replaced
from sjdsl.compiler.program import expressions as array
from sjdsl.runtime.actions import ANY_HEADING, HEADINGS, SAME_HEADING


class Pool(Record):
    """One destination of one phase use; `number` names it in the state of those who are away."""

    number: int
    send: ir.Send
    phase: str

    @property
    def kinds(self) -> tuple[str, ...]:
        return self.send.domain.var.kinds

    @property
    def sort(self) -> ir.Sort:
        """The sort of those who are sent."""
        return body_sort(self.send.who)


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
            at_once = w.keep("at_once", Value(array.Binary("&", sent, array.Binary("==", delays, array.Literal(0))), "bool")).node
            self.now.setdefault(pool.number, []).append(Sent(s, at_once, own))
            sent = w.keep("leaving", Value(array.Binary("&", sent, array.Binary(">", delays, array.Literal(0))), "bool")).node
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
    fits = _fits(s, axis, scope.always(), w)
    who = owner(s.who, scope, w)
    assert isinstance(who, AgentVar)
    if who.axis is not None:
        gone = tuple(a for a in scope.axes if a != who.axis)
        if any(a in fits.axes for a in gone):  # of those who send the agent, all say the same: any of them
            fits = reduce("any", both(scope.mask, fits) or TRUE, gone)
        return w.keep("fitting", Value(spread(fits, (who.axis, axis)), "bool")).node
    axes = union(who.index.axes, () if scope.mask is None else scope.mask.axes, tuple(a for a in fits.axes if a != axis))
    extent = w.module.extent(who.sort)
    at = w.keep(f"to_{who.sort.name}", Value(spread(select(scope.mask, who.index, Value(extent, "i32")), axes), "i32"))
    rows = spread(fits, (*axes, axis))
    table = array.call("jnp.zeros", array.Sequence((extent, axis.extent)), array.Name("bool"))
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
    return w.keep("delay", Value(of_each(s.who, delay, scope, w), "i32")).node


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
    earlier: list[tuple[Pool, array.Name]] = []
    for pool in sends.pools:
        parts = sends.now.get(pool.number, [])
        if not parts:
            continue
        w.origin = parts[0].send.origin
        sent = w.keep("sent", Value(_any_of([part.who for part in parts]), "bool")).node
        left = None
        if not any(s.stay for s in _sends_of(pool, w.module)):
            left = _any_of([sent, *(leaving.who for leaving in sends.away if leaving.pool is pool)])
        placed = place(pool, sent, left, _fitting(parts), w, earlier)
        earlier.append((pool, placed))
        _headings(pool, parts, placed, w)
        if w.module.stores_away(pool.sort):
            _put("away", pool.sort, placed, array.Literal(0), w)
    for leaving in sends.away:
        w.origin, sort = leaving.send.origin, leaving.pool.sort
        _put("position", sort, leaving.who, state_reads.nowhere(w).node, w)
        _put("away", sort, leaving.who, leaving.delays, w)
        _put("away_pool", sort, leaving.who, array.Literal(leaving.pool.number), w)
        _put("away_facing", sort, leaving.who, _facing(leaving.send, w), w)
    w.origin = None
    for sort, removed in sends.removed:
        _put("position", sort, removed, state_reads.nowhere(w).node, w)
        if w.module.stores_away(sort):
            _put("away", sort, removed, array.Literal(0), w)
    if sends.shifted:
        settle(sends.shifted, w)


def _fitting(parts: list[Sent]) -> array.Expression | None:
    """Returns which cells fit each agent that a pool sends, `[N, S]` bool; None if they are the same for all."""
    if parts[0].own is None or len(parts) == 1:
        return parts[0].own
    rows = [array.Binary("&", array.Index(part.who, (array.ALL, array.NEW_AXIS)), part.own) for part in parts if part.own is not None]
    return _any_of(list(rows))


def _put(name: str, sort: ir.Sort, who: array.Expression, value: array.Expression, w: Writer) -> None:
    """Gives a fact about some agents, or some movers of a sort, a new value."""
    attribute = attribute_of(name, sort)
    w.assign(attribute, array.Where(who, value, w.current(attribute)))


def _put_heading(sort: ir.Sort, who: array.Expression, heading: array.Expression, w: Writer) -> None:
    """Turns some agents or movers; the heading of a mover is a field, and so a byte."""
    if sort.what == "mover":
        heading = array.scalar(heading, "u8") if isinstance(heading, array.Literal) else array.Cast(heading, "u8")
    _put("heading", sort, who, heading, w)


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
    """Returns the number by which the state keeps a heading."""
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
    entered: list[tuple[Pool, array.Name]],
) -> array.Name:
    """Writes the placing of one pool; returns who found a cell. The cells of those who are `leaving` count as free.

    own: the cells that fit each agent, `[N, S]` bool; None where they are the same for all. entered: who has been placed before in this
    phase, by pool, `[N]` bool each.
    """
    attribute = attribute_of("position", pool.sort)
    free = _free_cells(pool, leaving, own is None, w, entered)
    placed = array.Name(w.names.fresh("placed"))
    before = w.current(attribute)
    position = w.changed.get(attribute) or array.Name(w.names.fresh(attribute))
    assert isinstance(position, array.Name)
    w.changed[attribute] = position
    bits = array.call("random_bits", KEY, w.stream(pool.send.order_stream), w.module.extent(pool.sort))
    among = (state_reads.cells_of(pool.kinds, w), free) if own is None else (state_reads.cells_of(pool.kinds, w), free, own)
    w.unpack((position, placed), array.call("place" if own is None else "place_fitting", *among, bits, before, sent))
    return placed


def _free_cells(
    pool: Pool, leaving: array.Expression | None, alike: bool, w: Writer, entered: Iterable[tuple[Pool, array.Name]] = ()
) -> array.Expression:
    """Returns which cells of a destination are free, `[S]` bool. `alike`: the same ones fit everybody; `leaving`, `entered`: as of `place`."""
    extent = w.module.num_cells(pool.kinds)
    axis = w.axis("destination", extent)
    free: Value | None = None

    def without(name: str, sites: array.Expression) -> Value | None:
        taken = array.call("occupied", w.keep(name, Value(sites, "i32")).node, extent)
        return both(free, Value(array.Unary("~", taken), "bool", (axis,)))

    if pool.phase != "start":
        free = without("others", _sites(pool, leaving, w))
    newly_there = [(other.sort, who) for other, who in entered if set(other.kinds) & set(pool.kinds)]
    for sort in dict.fromkeys(sort for sort, _ in newly_there):
        who: list[array.Expression] = [one for other, one in newly_there if other == sort]
        newly = array.Where(_any_of(who), w.current(attribute_of("position", sort)), state_reads.nowhere(w).node)
        free = without("entered", state_reads.site_at(Value(newly, "i32"), pool.kinds, w).node)
    if pool.send.domain.where is not None and alike:
        free = both(free, _fits(pool.send, axis, IterationScope(), w))
    if free is None or not free.axes:
        return array.call("jnp.full", extent, (free or TRUE).node)
    return w.keep("free", free).node


def _sites(pool: Pool, leaving: array.Expression | None, w: Writer) -> array.Expression:
    """Returns which cells of the destination somebody stands on, by their numbers: those of the pool's own sort first."""
    found: list[array.Expression] = []
    for sort in sorted(body_sorts(w.module.game), key=lambda sort: sort != pool.sort):
        site, _ = state_reads.site_under(state_reads.everybody(w, sort), pool.kinds, w)
        stays = leaving is None or sort != pool.sort
        found.append(site.node if stays else array.Where(leaving, w.module.num_cells(pool.kinds), site.node))  # type: ignore[arg-type]
    return found[0] if len(found) == 1 else array.call("jnp.concatenate", array.Sequence(tuple(found), is_list=True))


def _any_heading(pool: Pool, w: Writer) -> array.Expression:
    """Returns a random heading for each agent, or each mover of the pool's sort."""
    stream = w.stream(pool.send.heading_stream)
    return array.call("below", array.call("random_bits", KEY, stream, w.module.extent(pool.sort)), array.Literal(4))


def _headings(pool: Pool, parts: list[Sent], placed: array.Name, w: Writer) -> None:
    for part in parts:
        facing = part.send.facing
        if facing == "same":
            continue
        who = placed if len(parts) == 1 else array.Binary("&", part.who, placed)
        _put_heading(pool.sort, who, _any_heading(pool, w) if facing is None else heading_number(facing, w), w)


def bring_back(pools: dict[str, tuple[Pool, ...]], sorts: list[ir.Sort], w: Writer) -> None:
    """Writes the part of `tick` in which respawn delays count down and those return whose delay is over.

    They return pool by pool, each on the map as it then is. sorts: of those who can be sent away.
    """
    due: dict[ir.Sort, array.Expression] = {}
    left: dict[str, array.Expression] = {}
    for sort in sorts:
        away = array.path(f"state.{attribute_of('away', sort)}")
        is_nowhere = array.Binary("==", state_reads.positions(w, sort), state_reads.nowhere(w).node)
        due[sort] = w.bind("due", array.Binary("&", is_nowhere, array.Binary("==", away, array.Literal(1))))
        waiting = array.Cast(array.Binary("&", is_nowhere, array.Binary(">", away, array.Literal(1))), "i32")
        left[attribute_of("away", sort)] = array.Binary("-", away, waiting)
    w.set(array.Name("state"), replaced("state", left))
    for pool in (p for phase in pools.values() for p in phase):
        if any(s.after is not None for s in _sends_of(pool, w.module)):
            _return(pool, due[pool.sort], w)
    w.forget()
    w.origin = None


def _return(pool: Pool, due: array.Expression, w: Writer) -> None:
    """Writes how those come back to the map who were sent away to one pool."""
    w.forget()
    w.origin = pool.send.origin
    position, heading, away, away_facing, away_pool = (
        array.path(f"state.{attribute_of(name, pool.sort)}") for name in ("position", "heading", "away", "away_facing", "away_pool")
    )
    to_pool = array.Binary("==", away_pool, array.Literal(pool.number))
    back = w.keep("back", Value(array.Binary("&", due, to_pool), "bool")).node
    own = _of_those_who_return(pool, w)
    free = _free_cells(pool, None, own is None, w)
    number = w.module.extent(pool.sort)
    drawn = (array.call("random_bits", KEY, w.stream(s ^ ir.RETURN), number) for s in (pool.send.order_stream, pool.send.heading_stream))
    among = (state_reads.cells_of(pool.kinds, w), free, back, *drawn, position, heading, away_facing)
    attributes = [attribute_of(name, pool.sort) for name in ("position", "heading", "away")]
    new_position, new_heading, placed = (array.Name(w.names.fresh(name)) for name in (*attributes[:2], "placed"))
    w.unpack((new_position, new_heading, placed), array.call("come_back", *among, *(() if own is None else (own,))))
    new = (new_position, new_heading, array.Where(placed, array.Literal(0), away))
    w.set(array.Name("state"), replaced("state", dict(zip(attributes, new, strict=True))))


def _of_those_who_return(pool: Pool, w: Writer) -> array.Expression | None:
    """Returns which cells fit each agent when it comes back, `[N, S]` bool; None if they are the same for all."""
    s = next(s for s in _sends_of(pool, w.module) if s.after is not None)
    named = variables_around(s.domain)
    if not named:
        return None
    agents = w.axis(pool.sort.name, w.module.extent(pool.sort))
    axis = w.axis("destination", w.module.num_cells(s.domain.var.kinds))
    everybody = AgentVar(iota(agents), agents, pool.sort)
    scope = IterationScope(axes=(agents,), variables={variable.name: everybody for variable in named})
    return w.keep("fitting", Value(spread(_fits(s, axis, scope, w), (agents, axis)), "bool")).node

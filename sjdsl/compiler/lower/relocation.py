"""Lowers `send` and `remove`: collects who is sent over the phase, then spawns or respawns them on free cells, or settles shifts."""

from collections.abc import Iterable
from dataclasses import dataclass, field, replace

from sjdsl.compiler import ir
from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.ir.free_variables import variables_around
from sjdsl.compiler.ir.names import attribute_of
from sjdsl.compiler.ir.queries import body_sort, body_sorts
from sjdsl.compiler.lower import state_reads
from sjdsl.compiler.lower.axes import (
    TRUE,
    Axis,
    Value,
    aligned,
    as_dtype,
    binary,
    both,
    indexed,
    invert,
    iota,
    literal,
    reduce,
    select,
    spread,
    union,
)
from sjdsl.compiler.lower.domains import blocked_by, conditional_blocks, stand_on
from sjdsl.compiler.lower.draws import KEY
from sjdsl.compiler.lower.expressions import agent, owner
from sjdsl.compiler.lower.scope import AgentVar, CellVar, IterationScope
from sjdsl.compiler.lower.writer import Module, Writer, replaced
from sjdsl.compiler.program import expressions as array
from sjdsl.runtime.actions import ANY_HEADING, DIRECTIONS, HEADINGS, SAME_HEADING


def per_agent(e: ir.Expr, scope: IterationScope, w: Writer) -> Value:
    """Returns which agents a statement reaches, `[N]` bool."""
    who = agent(e, scope, w)
    if who.axis is not None:
        hit = reduce("any", scope.mask, tuple(a for a in scope.axes if a != who.axis))
        return (
            hit
            if hit.axes
            else Value(array.call("jnp.full", w.module.extent(who.sort), hit.node), "bool")
        )
    extent = w.module.extent(who.sort)
    at = w.keep(f"to_{who.sort.name}", select(scope.mask, who.index, Value(extent, "i32")))
    nobody = array.call("jnp.zeros", extent, array.DTYPES["bool"])
    return Value(array.written("set_at", nobody, (at.node,), array.Literal(True)), "bool")


def of_each(e: ir.Expr, value: Value, scope: IterationScope, w: Writer) -> array.Expression:
    """Returns a number from 0 on for each agent that a statement reaches, `[N]` int32, anything for the others.

    All instances that reach an agent say the same.
    """
    who = agent(e, scope, w)
    if who.axis is None:
        extent = w.module.extent(who.sort)
        at = select(scope.mask, who.index, Value(extent, "i32"))
        axes = union(at.axes, value.axes)
        places = w.keep(f"to_{who.sort.name}", Value(spread(at, axes), "i32", axes)).node
        zeros = array.call("jnp.zeros", extent, array.DTYPES["i32"])
        return array.written("set_at", zeros, (places,), spread(value, axes))
    over = tuple(a for a in value.axes if a != who.axis)
    if over:
        value = reduce(
            "max",
            select(scope.mask, value, literal(0, "i32")),
            tuple(a for a in scope.axes if a != who.axis),
        )
    return (
        value.node if value.axes else array.call("jnp.full", w.module.extent(who.sort), value.node)
    )


class _Ahead(Record):
    """From where, which way (0 to 3), and what is added to a cell of the frame for the next one."""

    at: Value
    heading: Value
    by: Value


class Shifted(Record):
    """Who is sent by one statement, `[N]` bool, and to which cell of the frame, `[N]` int32: its own if the way is not free."""

    statement: ir.Shift
    who: array.Expression
    target: array.Expression


def shifted(s: ir.Shift, scope: IterationScope, w: Writer) -> Shifted:
    """Returns where a statement sends whom."""
    who = agent(s.who, scope, w)
    sent = w.keep("sent", per_agent(s.who, scope, w)).node
    at = state_reads.position(who, w)
    if s.to is not None:
        goal = state_reads.frame_cell(state_reads.kept_cell(s.to, scope, w), w)
        goes = both(binary("!=", goal, state_reads.nowhere(w), "bool"), state_reads.present(who, w))
    else:
        assert s.steps is not None
        steps = as_dtype(w.value(s.steps, scope.always()), "i32")
        heading, there = _heading(s, who, at, scope, w)
        strides = array.constant([r * w.module.layout.cols + c for r, c in DIRECTIONS])
        stride = w.module.constant("stride", strides, "to the next cell, by heading", "i32")
        ahead = _Ahead(
            at,
            heading,
            w.keep("stride", Value(array.Index(stride, (heading.node,)), "i32", heading.axes)),
        )
        goes = both(
            binary(">", steps, literal(0, "i32"), "bool"),
            there,
            _is_free(s.steps.type, who, ahead, steps, w),
        )
        goal = w.keep("goal", _cells_on(ahead, steps, w))
    target = w.keep("target", select(goes, goal, at))
    return Shifted(s, sent, w.keep("target", Value(of_each(s.who, target, scope, w), "i32")).node)


def _cells_on(ahead: _Ahead, number: Value, w: Writer) -> Value:
    """Returns the cells so many cells on; they may lie beyond the map, unless it wraps."""
    layout = w.module.layout
    if not layout.wraps:
        return binary("+", ahead.at, binary("*", ahead.by, number, "i32"), "i32")
    axes = union(ahead.at.axes, ahead.heading.axes, number.axes)
    parts = [
        aligned(x, axes)
        for x in (
            ahead.at,
            replace(ahead.heading, node=array.as_array(ahead.heading.node, "i32")),
            number,
        )
    ]
    return Value(
        array.call(
            "cells_on",
            *parts,
            *map(array.Literal, (layout.height, layout.width)),
            array.Name("PAD"),
        ),
        "i32",
        axes,
    )


def _heading(
    s: ir.Shift, who: AgentVar, at: Value, scope: IterationScope, w: Writer
) -> tuple[Value, Value]:
    """Returns which way an agent is sent, 0 to 3, and whether there is such a way."""
    if s.heading is not None:
        numbers = [HEADINGS.index(word) for word in s.heading.type.words]
        value = w.value(s.heading, scope.always())
        if value.literal:
            return literal((numbers[int(value.number)] + s.quarters) % 4, "i32"), TRUE
        if numbers == list(range(len(HEADINGS))):
            return _turned(as_dtype(value, "i32"), s.quarters), TRUE
        table = array.as_array(array.constant([(n + s.quarters) % 4 for n in numbers]), "i32")
        return replace(value, node=array.Index(table, (value.node,)), dtype="i32"), TRUE
    assert s.other is not None
    other = owner(s.other, scope, w)
    goal = (
        state_reads.position(other, w)
        if isinstance(other, AgentVar)
        else state_reads.cell(other, w)
    )
    rows, columns = (
        w.keep(name, _apart(goal, at, op, w)) for name, op in (("rows", "//"), ("columns", "%"))
    )
    lengths = (w.module.layout.height, w.module.layout.width)
    if w.module.layout.wraps:
        ways = zip((rows, columns), lengths, strict=True)
        rows, columns = (
            w.keep("shorter", replace(x, node=array.call("shorter_way", x.node, array.Literal(n))))
            for x, n in ways
        )
    down, across = (replace(x, node=array.call("jnp.abs", x.node)) for x in (rows, columns))
    looks = Value(
        array.Binary("&", state_reads.heading(who, w).node, array.Literal(1)),
        "i32",
        state_reads.heading(who, w).axes,
    )
    upright = select(
        binary("==", down, across, "bool"),
        binary("==", looks, literal(0, "i32"), "bool"),
        binary(">", down, across, "bool"),
    )
    vertical = select(
        binary("<", rows, literal(0, "i32"), "bool"), literal(0, "i32"), literal(2, "i32")
    )
    level = select(
        binary("<", columns, literal(0, "i32"), "bool"), literal(3, "i32"), literal(1, "i32")
    )
    toward, apart = select(upright, vertical, level), binary("!=", goal, at, "bool")
    if (
        w.module.layout.wraps
    ):  # where both ways round are equally long: the one in which the agent looks
        halves = (binary("*", literal(2, "i32"), x, "i32") for x in (rows, columns))
        equal = [
            binary("==", half, literal(length, "i32"), "bool")
            for half, length in zip(halves, lengths, strict=True)
        ]
        either, looks = w.keep("either_way", select(upright, *equal)), state_reads.heading(who, w)
        line, way = (
            Value(array.Binary("&", x.node, array.Literal(1)), "i32", x.axes)
            for x in (looks, toward)
        )
        stuck = w.keep("stuck", binary("&", either, binary("!=", line, way, "bool"), "bool"))
        toward, apart = select(either, looks, toward), both(apart, invert(stuck))
    return _turned(toward, s.quarters), apart


def _apart(goal: Value, at: Value, op: str, w: Writer) -> Value:
    """Returns how many rows (`//`) or columns (`%`) lie from one cell to another."""
    cols = w.module.number("frame_cols", w.module.layout.cols)
    there, here = (replace(place, node=array.Binary(op, place.node, cols)) for place in (goal, at))
    return binary("-", there, here, "i32")


def _turned(heading: Value, quarters: int) -> Value:
    if not quarters:
        return heading
    more = binary("+", heading, literal(quarters, "i32"), "i32")
    return replace(more, node=array.Binary("&", more.node, array.Literal(3)))


def _is_free(number_of: ir.Type, who: AgentVar, ahead: _Ahead, steps: Value, w: Writer) -> Value:
    """Returns whether every cell on the way is on the map, open to the agent, and (but for the last one) empty; `number_of` the steps."""
    most = int(number_of.high)
    if most == 0:
        return TRUE
    if most == 1:
        return _is_open(w.keep("ahead", _cells_on(ahead, literal(1, "i32"), w)), who, w)
    everybody = state_reads.all_positions(w)
    axis = w.axis("way", most)
    number = binary("+", iota(axis), literal(1, "i32"), "i32")
    cells = w.keep("way", _cells_on(ahead, number, w))
    clear = _is_open(cells, who, w)
    standing = Value(
        array.reduction("any", stand_on(cells, everybody), (len(cells.axes),)), "bool", cells.axes
    )
    last = binary(">=", number, steps, "bool")
    clear = both(clear, invert(select(last, literal(False, "bool"), standing)))
    if number_of.low < most:  # what lies beyond the last cell does not matter
        clear = select(binary(">", number, steps, "bool"), literal(True, "bool"), clear)
    return w.keep("clear", reduce("all", clear, (axis,)))


def _is_open(cells: Value, who: AgentVar, w: Writer) -> Value:
    """Returns which cells of the frame are on the map and do not block an agent, or a mover of a sort."""
    what = who.sort.plural
    layout = w.module.layout
    inside = w.module.constant("inside", layout.inside_table, "cells of the map in the frame")
    clear = Value(indexed(inside, (cells.node,)), "bool", cells.axes)
    if layout.count(layout.blocking_glyphs(what)):
        fixed = w.module.constant(
            f"blocks_{what}", layout.blocking_table(what), f"cells that always block {what}"
        )
        clear = both(
            clear, Value(array.Unary("~", array.Index(fixed, (cells.node,))), "bool", cells.axes)
        )
    for block, kind in conditional_blocks(what, w):
        clear = both(clear, invert(blocked_by(block, kind, cells, w, who)))
    return clear


def settle(moves: list[Shifted], w: Writer) -> None:
    """Writes where all who are sent come to stand; those sent elsewhere in this phase have their new places already.

    Each sort of movers in turn, then the agents: they find the others where these then are.
    """
    agents, *movers = body_sorts(w.module.game)
    for sort in (*movers, agents):
        own = [move for move in moves if body_sort(move.statement.who) == sort]
        if own:
            position, extent = attribute_of("position", sort), w.module.extent(sort)
            before = w.bind("before", w.current(position))
            targets: array.Expression = before
            words: array.Expression = array.call("jnp.zeros", extent, array.path("jnp.uint32"))
            for move in own:
                w.origin = move.statement.origin
                bits = array.call("random_bits", KEY, w.stream(move.statement.stream), extent)
                targets = array.Where(move.who, move.target, targets)
                words = bits if len(own) == 1 else array.Where(move.who, bits, words)
            for other in (
                other for other in body_sorts(w.module.game) if other != sort
            ):  # who stands on a cell keeps it
                taken = array.call("is_one_of", targets, w.current(attribute_of("position", other)))
                targets = array.Where(taken, before, targets)
            w.assign(
                position,
                array.call("resolve", before, targets, words, exchange=array.Literal(True)),
            )
            came = array.Binary("!=", w.current(position), before)
            for move in own:
                _turn(
                    sort,
                    array.Binary("&", move.who, came),
                    move.statement.facing,
                    move.statement.heading_stream,
                    w,
                )
    w.origin = None


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
    fits = _fits(s, axis, scope.always(), w)
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
    return w.keep("fitting", Value(array.written("set_at", table, (at.node,), rows), "bool")).node


def _fits(s: ir.Send, axis: Axis, scope: IterationScope, w: Writer) -> Value:
    """Returns where a destination's `where` holds, along the axis of its cells and those of the variables it names."""
    assert s.domain.where is not None
    variable = CellVar(iota(axis), s.domain.var.kinds, axis)
    return w.value(
        s.domain.where,
        replace(scope.binding(**{s.domain.var.name: variable}), axes=(*scope.axes, axis)),
    )


def _delays(s: ir.Send, delay: Value, scope: IterationScope, w: Writer) -> array.Expression:
    """Returns the ticks each agent is away, `[N]` int32 or a number (all sends that reach one agent agree)."""
    if delay.literal and s.after is not None and s.after.type.low > 0:
        return delay.node
    if not delay.axes:
        return w.keep(
            "delay", Value(array.scalar(delay.node, "i32") if delay.literal else delay.node, "i32")
        ).node
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
        own = parts[0].own
        if own is not None and len(parts) > 1:
            rows = (
                (array.Index(part.who, (array.ALL, array.NEW_AXIS)), part.own)
                for part in parts
                if part.own is not None
            )
            own = _any_of([array.Binary("&", sent_here, fitting) for sent_here, fitting in rows])
        placed = place(pool, sent, left, own, w, earlier)
        earlier.append((pool, placed))
        for part in parts:
            who = placed if len(parts) == 1 else array.Binary("&", part.who, placed)
            _turn(pool.sort, who, part.send.facing, pool.send.heading_stream, w)
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


def _put(
    name: str, sort: ir.Sort, who: array.Expression, value: array.Expression, w: Writer
) -> None:
    """Gives a fact about some agents, or some movers of a sort, a new value."""
    attribute = attribute_of(name, sort)
    w.assign(attribute, array.Where(who, value, w.current(attribute)))


def _any_of(who: list[array.Expression]) -> array.Expression:
    first, *rest = who
    for other in rest:
        first = array.Binary("|", first, other)
    return first


def _turn(
    sort: ir.Sort, who: array.Expression, facing: str | None, stream: int | None, w: Writer
) -> None:
    """Turns some agents or movers as a statement says; the heading of a mover is a field, and so a byte."""
    heading: array.Expression
    if facing == "same":
        return
    if facing is None:
        assert stream is not None
        heading = array.call(
            "below",
            array.call("random_bits", KEY, w.stream(stream), w.module.extent(sort)),
            array.Literal(4),
        )
        heading = array.Cast(heading, "u8") if sort.what == "mover" else heading
    else:
        heading = w.module.number(facing, HEADINGS.index(facing))
        heading = array.scalar(heading, "u8") if sort.what == "mover" else heading
    _put("heading", sort, who, heading, w)


def _facing(s: ir.Send, w: Writer) -> array.Literal:
    """Returns the heading that an agent sent away will have."""
    match s.facing:
        case None:
            return w.module.number("any_heading", ANY_HEADING)
        case "same":
            return w.module.number("same_heading", SAME_HEADING)
        case heading:
            return w.module.number(heading, HEADINGS.index(heading))


def _sends_of(pool: Pool, module: Module) -> list[ir.Send]:
    """Returns all statements that send to a pool."""
    return [s for s in module.sends if s.cell_stream == pool.send.cell_stream]


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


def _free_cells(
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
            _any_of(who), w.current(attribute_of("position", sort)), state_reads.nowhere(w).node
        )
        free = without("entered", state_reads.site_at(Value(newly, "i32"), pool.kinds, w).node)
    if pool.send.domain.where is not None and alike:
        free = both(free, _fits(pool.send, axis, IterationScope(), w))
    if free == TRUE:
        return array.Literal(None)  # all of them
    return w.keep("free", free).node if free.axes else array.call("jnp.full", extent, free.node)


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
        if any(s.after is not None for s in _sends_of(pool, w.module)):
            w.forget()
            w.origin = pool.send.origin
            position, heading, away, away_facing, away_pool = (
                array.path(f"state.{attribute_of(name, pool.sort)}")
                for name in ("position", "heading", "away", "away_facing", "away_pool")
            )
            to_pool = array.Binary("==", away_pool, array.Literal(pool.number))
            back = w.keep("back", Value(array.Binary("&", due[pool.sort], to_pool), "bool")).node
            own = _of_those_who_return(pool, w)
            free = _free_cells(pool, None, own is None, w)
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
    s = next(s for s in _sends_of(pool, w.module) if s.after is not None)
    named = variables_around(s.domain)
    if not named:
        return None
    agents = w.axis(pool.sort.name, w.module.extent(pool.sort))
    axis = w.axis("destination", w.module.num_cells(s.domain.var.kinds))
    everybody = AgentVar(iota(agents), agents, pool.sort)
    scope = IterationScope(
        axes=(agents,), variables={variable.name: everybody for variable in named}
    )
    return w.keep("fitting", Value(spread(_fits(s, axis, scope, w), (agents, axis)), "bool")).node

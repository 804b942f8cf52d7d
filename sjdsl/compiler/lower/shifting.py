"""Lowers `send x by n DIRECTION` and `send x to CELL`: the way of each agent, then all who are sent in one phase settled together."""

from dataclasses import replace

from sjdsl.compiler import ir
from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.ir.names import attribute_of
from sjdsl.compiler.ir.queries import body_sort, body_sorts
from sjdsl.compiler.lower import state_reads
from sjdsl.compiler.lower.axes import (
    TRUE,
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
    union,
)
from sjdsl.compiler.lower.domains import blocked_by, conditional_blocks, stand_on
from sjdsl.compiler.lower.draws import KEY
from sjdsl.compiler.lower.expressions import agent, owner
from sjdsl.compiler.lower.per_agent import of_each, per_agent, turn
from sjdsl.compiler.lower.scope import AgentVar, IterationScope
from sjdsl.compiler.lower.writer import Writer
from sjdsl.compiler.program import expressions as array
from sjdsl.runtime.actions import DIRECTIONS, HEADINGS


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
        array.Reduce("any", stand_on(cells, everybody), (len(cells.axes),)), "bool", cells.axes
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
                turn(
                    sort,
                    array.Binary("&", move.who, came),
                    move.statement.facing,
                    move.statement.heading_stream,
                    w,
                )
    w.origin = None

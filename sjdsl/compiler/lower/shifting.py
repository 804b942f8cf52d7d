"""Lowers `send x by n DIRECTION`, and `send x to CELL` for one certain cell.

Each statement computes where it sends whom (`shifted`). At the end of the phase all who are sent in
it move at once, and the kernel `resolve` settles collisions (`settle`).
"""

from dataclasses import replace

from sjdsl.compiler import ir
from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.ir.names import attribute_of
from sjdsl.compiler.ir.queries import body_type, body_types
from sjdsl.compiler.lower import state_reads
from sjdsl.compiler.lower.axes import (
    FALSE,
    TRUE,
    Value,
    as_dtype,
    called,
    iota,
    literal,
    looked_up,
    reduce,
    select,
)
from sjdsl.compiler.lower.domains import (
    always_block,
    blocked_by,
    conditional_blocks,
    is_inside,
    stand_on,
)
from sjdsl.compiler.lower.draws import bits_of_each
from sjdsl.compiler.lower.expressions import agent, owner
from sjdsl.compiler.lower.per_agent import (
    of_each,
    per_agent,
    turn,
    turned,
    way_of_each,
    written_heading,
)
from sjdsl.compiler.lower.scope import AgentVar, IterationScope
from sjdsl.compiler.lower.writer import Writer
from sjdsl.compiler.program.expressions import (
    Expression,
    Name,
    Where,
    as_array,
    call,
    reduction,
    zeros,
)
from sjdsl.runtime.actions import DIRECTIONS


class _Course(Record):
    """A straight course.

    start: cells of the frame. heading: 0 to 3. stride: what to add to a cell for the next one.
    """

    start: Value
    heading: Value
    stride: Value


class Shifted(Record):
    """Whom one statement sends.

    who: `[N]` bool. target: where to, `[N]` int32 cells of the frame; its own cell for an agent
    whose way isn't free. way: its heading afterwards, `[N]` int32, if the statement computes it.
    """

    statement: ir.Shift
    who: Expression
    target: Expression
    way: Expression | None


def shifted(s: ir.Shift, scope: IterationScope, w: Writer) -> Shifted:
    """Returns whom a statement sends, and where."""
    who = agent(s.who, scope, w)
    sent = per_agent("sent", s.who, scope, w)
    position = state_reads.position(who, w)
    if s.to is not None:
        goal = state_reads.frame_cell(state_reads.kept_cell(s.to, scope, w), w)
        goes = goal.ne(state_reads.nowhere(w)) & state_reads.present(who, w)
    else:
        assert s.steps is not None
        steps = as_dtype(w.value(s.steps, scope), "i32")
        heading, has_heading = _heading(s, who, position, scope, w)
        course = _Course(position, heading, _stride(heading, w))
        is_free = _is_free(s.steps.type, who, course, steps, w)
        goes = (steps > 0) & has_heading & is_free
        goal = w.keep("goal", _cells_on(course, steps, w))
    target = w.keep("target", select(goes, goal, position))
    target_of_each = w.keep_node("target", of_each(s.who, target, scope, w), "i32")
    return Shifted(s, sent, target_of_each, way_of_each(s.who, s.way, scope, w))


def _stride(heading: Value, w: Writer) -> Value:
    """Returns what to add to a cell of the frame for the next one in a direction."""
    cols = w.layout.cols
    strides = [row * cols + col for row, col in DIRECTIONS]
    table = w.module.constant("stride", strides, "to the next cell, by heading", "i32")
    return w.keep("stride", looked_up(table, heading, "i32"))


def _cells_on(course: _Course, number: Value, w: Writer) -> Value:
    """Returns the cells that many steps along a course; beyond the map too, unless it wraps."""
    layout = w.layout
    if not layout.wraps:
        return course.start + course.stride * number
    heading = replace(course.heading, node=as_array(course.heading.node, "i32"))
    size = (layout.height, layout.width, Name("PAD"))
    return called("cells_on", course.start, heading, number, *size)


def _heading(
    s: ir.Shift, who: AgentVar, position: Value, scope: IterationScope, w: Writer
) -> tuple[Value, Value]:
    """Returns in which direction an agent is sent, 0 to 3, and whether there is a direction."""
    if s.heading is not None:
        return written_heading(s.heading, s.quarters, scope, w), TRUE
    assert s.other is not None
    goal = state_reads.location(owner(s.other, scope, w), w)
    heading, can_go = _toward(goal, who, position, w)
    return turned(heading, s.quarters), can_go


def _toward(goal: Value, who: AgentVar, position: Value, w: Writer) -> tuple[Value, Value]:
    """Returns the heading toward a cell, and whether the agent can go there.

    It goes along the longer of the two sides, rows or columns; of equal ones along that on which
    it looks. On a wrapping map it goes the shorter way round; of two equal ways the one in which it
    looks, and if it looks across them, it can't go. Nor can it if the cell is its own.
    """
    layout = w.layout
    frame_cols = w.module.frame_cols
    rows = w.keep("rows", goal // frame_cols - position // frame_cols)
    cols = w.keep("columns", goal % frame_cols - position % frame_cols)
    if layout.wraps:
        rows = w.keep("shorter", called("shorter_way", rows, layout.height))
        cols = w.keep("shorter", called("shorter_way", cols, layout.width))
    num_rows = called("jnp.abs", rows)
    num_cols = called("jnp.abs", cols)
    own_heading = state_reads.heading(who, w)
    is_vertical = select(num_rows.eq(num_cols), (own_heading & 1).eq(0), num_rows > num_cols)
    north_or_south = select(rows < 0, literal(0, "i32"), 2)
    west_or_east = select(cols < 0, literal(3, "i32"), 1)
    toward = select(is_vertical, north_or_south, west_or_east)
    can_go = goal.ne(position)
    if layout.wraps:
        half_rows = _is_half(rows, layout.height)
        half_cols = _is_half(cols, layout.width)
        either_way = w.keep("either_way", select(is_vertical, half_rows, half_cols))
        looks_across = (own_heading & 1).ne(toward & 1)
        stuck = w.keep("stuck", either_way & looks_across)
        toward = select(either_way, own_heading, toward)
        can_go = can_go & ~stuck
    return toward, can_go


def _is_half(distance: Value, length: int) -> Value:
    """Returns whether a distance is half the way round the map."""
    return (literal(2, "i32") * distance).eq(length)


def _is_free(number_of: ir.Type, who: AgentVar, course: _Course, steps: Value, w: Writer) -> Value:
    """Returns whether every cell on the way is on the map, open and, but for the last one, empty.

    number_of: the type of `steps`, which says how many there can be.
    """
    most = int(number_of.high)
    if most == 0:
        return TRUE
    if most == 1:
        ahead = _cells_on(course, literal(1, "i32"), w)
        return _is_open(w.keep("ahead", ahead), who, w)
    bodies = state_reads.all_positions(w)
    axis = w.axis("way", most)
    number = iota(axis) + 1
    cells = w.keep("way", _cells_on(course, number, w))
    is_open = _is_open(cells, who, w)
    has_body = reduction("any", stand_on(cells, bodies), (len(cells.axes),))
    taken = select(number >= steps, FALSE, Value(has_body, "bool", cells.axes))
    free = is_open & ~taken
    if number_of.low < most:  # what lies beyond the last cell does not matter
        free = select(number > steps, TRUE, free)
    return w.keep("clear", reduce("all", free, (axis,)))


def _is_open(cells: Value, who: AgentVar, w: Writer) -> Value:
    """Returns which cells of the frame are on the map and do not block the agent or mover."""
    name = who.entity_type.plural
    layout = w.layout
    is_open = is_inside(cells, w)
    if layout.count(layout.blocking_glyphs(name)):
        is_open = is_open & ~always_block(cells, name, w)
    for block, kind in conditional_blocks(name, w):
        is_open = is_open & ~blocked_by(block, kind, cells, w, who)
    return is_open


def settle(moves: list[Shifted], w: Writer) -> None:
    """Writes the new cells of all who are shifted in a phase.

    Movers go first, one name after the other, then agents. Each group finds the groups before it on
    their new cells, as those whom `send ... to KIND` has placed.
    """
    agents, *movers = body_types(w.game)
    for entity_type in (*movers, agents):
        moves_of_type = [move for move in moves if body_type(move.statement.who) == entity_type]
        if moves_of_type:
            _settle_type(entity_type, moves_of_type, w)
    w.origin = None


def _settle_type(entity_type: ir.EntityType, moves: list[Shifted], w: Writer) -> None:
    """Writes the new cells of the agents, or of the movers of a name, that a phase shifts.

    Who wants a cell on which somebody of another type is stays.
    """
    position = attribute_of("position", entity_type)
    extent = w.module.extent(entity_type)
    before = w.bind("before", w.current(position))
    targets: Expression = before
    ranks: Expression = zeros("u32", extent)
    for move in moves:
        w.origin = move.statement.origin
        bits = bits_of_each(move.statement.stream, entity_type, w)
        targets = Where(move.who, move.target, targets)
        ranks = bits if len(moves) == 1 else Where(move.who, bits, ranks)
    for other in body_types(w.game):
        if other != entity_type:
            taken = call("is_one_of", targets, w.current(attribute_of("position", other)))
            targets = Where(taken, before, targets)
    resolved = call("resolve", before, targets, ranks, exchange=True)
    w.assign(position, resolved)
    has_moved = w.current(position).ne(before)
    for move in moves:
        s = move.statement
        turn(entity_type, move.who & has_moved, s.facing, move.way, s.heading_stream, w)

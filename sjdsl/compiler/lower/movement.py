"""Lowers `move`: agents step as they chose, movers on their course; then collisions are settled.

First each one's target is computed, its own cell if it stays. The kernel `resolve` then decides who
reaches it.
"""

from sjdsl.compiler import ir
from sjdsl.compiler.ir.entity_types import AGENTS
from sjdsl.compiler.ir.names import attribute_of
from sjdsl.compiler.lower import state_reads
from sjdsl.compiler.lower.axes import (
    TRUE,
    Axis,
    Value,
    aligned,
    as_dtype,
    broadcast,
    iota,
    looked_up,
    select,
    spread,
    without,
)
from sjdsl.compiler.lower.domains import blocked_by, conditional_blocks, enter, is_empty
from sjdsl.compiler.lower.draws import bits_of_each
from sjdsl.compiler.lower.entries import to_words
from sjdsl.compiler.lower.expressions import agent
from sjdsl.compiler.lower.scope import AgentVar, IterationScope, NotSupported
from sjdsl.compiler.lower.state_reads import HEADING, POSITION
from sjdsl.compiler.lower.writer import Writer
from sjdsl.compiler.program.expressions import (
    Expression,
    Literal,
    Name,
    Where,
    call,
    path,
    zeros,
)
from sjdsl.runtime.actions import HEADINGS, STEPS, TURNS

NO_STEP = 4  # the direction of an action that is no step


def move(s: ir.Move, scope: IterationScope, w: Writer) -> None:
    """Writes `move each agent`: they turn and step as their actions say."""
    game = w.game
    inner = enter(s.domain, scope, w)
    actions = game.agents.actions
    turns = [TURNS.get(action, 0) for action in actions]
    steps = [STEPS.get(action, NO_STEP) for action in actions]
    turn = w.module.constant("turn", turns, "quarter turns to the right by action", "i32")
    step = w.module.constant("step_by", steps, "direction of a step by action; 4: none", "i32")
    comment = "where a step leads, by cell and direction; the cell itself if blocked"
    table = w.module.constant("next_cell", w.layout.next_table(), comment)
    chosen: Expression = Name("actions")
    if inner.mask != TRUE:
        stay = Literal(actions.index("stay"), "STAY")
        chosen = w.keep_node("chosen", Where(inner.mask.node, chosen, stay), "i32")
    w.assign("heading", (HEADING + turn[chosen]) & 3)
    stride = w.bind("stride", step[chosen])
    ahead = w.current("heading") + stride if game.agents.relative else stride
    entry = POSITION * 4 + (ahead & 3)
    stays = stride.eq(w.module.number("no_step", NO_STEP))
    target = w.bind("target", Where(stays, POSITION, table[entry]))
    stay_if_blocked(agent(s.domain.var, inner, w), target, w)
    settle(s, AGENTS, target, w)


def nobody_moves(s: ir.Move, w: Writer) -> None:
    """Writes a movement phase of a domain that has no members on this map."""
    entity_type = s.domain.var.entity_type
    if w.module.stores_moved(entity_type):
        attribute = attribute_of("moved", entity_type)
        w.assign(attribute, call("jnp.zeros_like", path(f"state.{attribute}")))


def settle(s: ir.Move, entity_type: ir.EntityType, target: Name, w: Writer) -> None:
    """Writes the cells of agents, or of the movers of a name, after they have moved.

    target: the cell that each wants, `[N]`.
    """
    position = state_reads.positions(w, entity_type)
    attribute = attribute_of("position", entity_type)
    if w.game.movers:  # those of other types stay, and so do all who want a cell of theirs
        taken = call("is_one_of", target, state_reads.all_positions(w, but=entity_type))
        w.set(target, Where(taken, position, target))
    bits = bits_of_each(s.stream, entity_type, w)
    w.assign(attribute, call("resolve", position, target, bits))
    if w.module.stores_moved(entity_type):
        w.assign(attribute_of("moved", entity_type), w.current(attribute).ne(position))


def stay_if_blocked(body: AgentVar, target: Name, w: Writer) -> None:
    """Writes that who would enter a cell that blocks under a condition has its own as target."""
    position = state_reads.positions(w, body.entity_type)
    for block, kind in conditional_blocks(body.entity_type.plural, w):
        if body.axis is None:
            feature = "`move each` of agents named one by one where cells block under a condition"
            raise NotSupported(feature, w.origin)
        blocked = blocked_by(block, kind, Value(target, "i32", (body.axis,)), w, body)
        moves = Value(target.ne(position), "bool", (body.axis,))
        w.set(target, Where((blocked & moves).node, position, target))
        w.forget()


def move_on_course(s: ir.Move, scope: IterationScope, w: Writer) -> None:
    """Writes `move each deer along HEADING`, or `at random`, `toward` or `away from` something."""
    course = s.course
    assert course is not None
    inner = enter(s.domain, scope, w)
    mover = agent(s.domain.var, inner, w)
    if mover.axis is None:
        instead = "say with `where` which of them move"
        raise NotSupported("`move each` of movers that are named one by one", s.origin, instead)
    axes = (mover.axis,)
    position = state_reads.position(mover, w)
    match course:
        case ir.Along():
            value = w.value(course.heading, inner)
            heading = to_words(value, course.heading.type.words, HEADINGS, w)
            direction = w.keep("way", as_dtype(broadcast(heading, axes), "i32"))
            goes = inner.mask
        case ir.Wander():
            direction, goes = _open_direction(course, inner, mover, w)
    if goes != TRUE:
        goes = broadcast(goes, axes)
    next_cell = looked_up(_next_table(mover.entity_type, w), position * 4 + direction, "i32")
    target = w.bind("target", select(goes, next_cell, position).node)
    if isinstance(course, ir.Along):
        stay_if_blocked(mover, target, w)
    if not _keeps_heading(course):
        attribute = attribute_of("heading", mover.entity_type)
        before = Value(path(f"state.{attribute}"), "u8", axes)
        turned = select(goes, as_dtype(direction, "u8"), before)
        w.assign(attribute, turned.node)
    settle(s, mover.entity_type, target, w)


def _next_table(entity_type: ir.EntityType, w: Writer) -> Name:
    comment = (
        f"where a step leads {entity_type.name}, by cell and direction; the cell itself if blocked"
    )
    table = w.layout.next_table(entity_type.name)
    return w.module.constant(f"next_cell_of_{entity_type.name}", table, comment)


def _keeps_heading(course: ir.Along | ir.Wander) -> bool:
    """Returns whether movers go along the heading that they have already."""
    if not isinstance(course, ir.Along) or not isinstance(course.heading, ir.FieldRead):
        return False
    read = course.heading
    return read.held_by.what == "mover" and read.name == "heading"


def _open_direction(
    course: ir.Wander, scope: IterationScope, mover: AgentVar, w: Writer
) -> tuple[Value, Value]:
    """Returns in which direction each mover goes, a random open one, and whether it goes at all.

    Open are directions to an empty cell that doesn't block the mover, isn't avoided, and is nearer
    to the goal, or farther from it, if there is one.
    """
    assert mover.axis is not None
    axis = mover.axis
    directions = w.axis("way", 4)
    axes = (axis, directions)
    position = state_reads.positions(w, mover.entity_type)[:, None]
    entry = position * 4 + iota(directions).node[None, :]
    beside = w.keep("beside", Value(_next_table(mover.entity_type, w)[entry], "i32", axes))
    taken = call("is_one_of", beside.node, state_reads.all_positions(w))
    is_elsewhere = beside.node.ne(position)  # a step that is blocked leads to the mover's own cell
    is_open = Value(is_elsewhere & ~taken, "bool", axes)
    for block, kind in conditional_blocks(mover.entity_type.plural, w):
        is_open = is_open & ~blocked_by(block, kind, beside, w, mover)
    if course.avoided is not None and not is_empty(course.avoided, w):
        cells, is_member = _members(course.avoided, scope, axis, w)
        avoided = Where(is_member, cells, Literal(-1))  # a row of cells for each mover
        is_avoided = call("is_one_of", beside.node, avoided[:, None, :])
        is_open = is_open & Value(~is_avoided, "bool", axes)
    if course.goal is not None:
        is_better = _better(course.goal, course.away, scope, mover, axis, w)
        is_open = is_open & Value(is_better, "bool", axes)
    bits = bits_of_each(course.stream, mover.entity_type, w)
    direction, has_way = w.keep_parts(("way", "found"), call("pick", is_open.node, bits))
    goes = w.keep("goes", scope.mask & Value(has_way, "bool", (axis,)))
    return Value(direction, "i32", (axis,)), goes


def _better(
    goal: ir.Domain, away: bool, scope: IterationScope, mover: AgentVar, axis: Axis, w: Writer
) -> Expression:
    """Returns which steps bring each mover nearer to the nearest member of a goal: `[M, 4]` bool.

    away: those that bring it farther from that member instead.
    """
    if is_empty(goal, w):
        return zeros("bool", axis.extent, 4)
    cells, is_member = _members(goal, scope, axis, w)
    layout = w.layout
    positions = state_reads.positions(w, mover.entity_type)
    around = {"around": (layout.height, layout.width)} if layout.wraps else {}
    gained = call("gains", positions, cells, is_member, w.module.frame_cols, **around)
    return gained > 0 if away else gained < 0


def _members(
    d: ir.Domain, scope: IterationScope, axis: Axis, w: Writer
) -> tuple[Expression, Expression]:
    """Returns the cells of a domain's candidates, and which of them are members.

    Both are `[M, T]`, or `[1, T]` if they are the same for all movers.
    """
    inner = enter(d, scope.always(), w)
    cells = state_reads.location(inner.variables[d.var.name], w)
    is_member = inner.mask
    added = without(inner.axes, scope.axes)
    if not added:  # one candidate for each mover
        return spread(cells, (axis,))[:, None], spread(is_member, (axis,))[:, None]
    if not is_member.axes:
        is_member = broadcast(is_member, added)
    return aligned(cells, (axis, *added)), aligned(is_member, (axis, *added))

"""Lowers `move`: agents step as they chose, movers on their course; then collisions of all at once are settled."""

from sjdsl.compiler import ir
from sjdsl.compiler.ir.names import attribute_of
from sjdsl.compiler.ir.sorts import AGENTS
from sjdsl.compiler.lower import state_reads
from sjdsl.compiler.lower.axes import (
    TRUE,
    Axis,
    Value,
    aligned,
    as_dtype,
    binary,
    both,
    invert,
    iota,
    spread,
)
from sjdsl.compiler.lower.domains import blocked_by, conditional_blocks, enter, is_empty
from sjdsl.compiler.lower.draws import KEY
from sjdsl.compiler.lower.entries import to_words
from sjdsl.compiler.lower.expressions import agent
from sjdsl.compiler.lower.scope import AgentVar, CellVar, IterationScope, NotSupported
from sjdsl.compiler.lower.writer import Writer
from sjdsl.compiler.program.expressions import (
    ALL,
    NEW_AXIS,
    Binary,
    Cast,
    Expression,
    Index,
    Literal,
    Name,
    Sequence,
    Unary,
    Where,
    call,
    constant,
    path,
)
from sjdsl.runtime.actions import HEADINGS, STEPS, TURNS

NO_STEP = 4
POSITION, HEADING = path("state.position"), path("state.heading")


def move(s: ir.Move, scope: IterationScope, w: Writer) -> None:
    """Writes a movement phase."""
    game, layout = w.module.game, w.module.layout
    inner = enter(s.domain, scope, w)
    actions = game.agents.actions
    turns, steps = (
        constant([found.get(a, other) for a in actions])
        for found, other in ((TURNS, 0), (STEPS, NO_STEP))
    )
    turn = w.module.constant("turn", turns, "quarter turns to the right by action", "i32")
    step = w.module.constant("step_by", steps, "direction of a step by action; 4: none", "i32")
    table = w.module.constant(
        "next_cell",
        layout.next_table(),
        "where a step leads, by cell and direction; the cell itself if blocked",
    )
    chosen = Value(Name("actions"), "i32")
    if inner.mask != TRUE:
        stay = Literal(actions.index("stay"), "STAY")
        chosen = w.keep("chosen", Value(Where(inner.mask.node, Name("actions"), stay), "i32"))
    w.assign("heading", Binary("&", Binary("+", HEADING, Index(turn, (chosen.node,))), Literal(3)))
    stride = w.bind("stride", Index(step, (chosen.node,)))
    ahead = Binary("+", w.current("heading"), stride) if game.agents.relative else stride
    next_cell = Index(
        table, (Binary("+", Binary("*", POSITION, Literal(4)), Binary("&", ahead, Literal(3))),)
    )
    stays = Binary("==", stride, w.module.number("no_step", NO_STEP))
    target = w.bind("target", Where(stays, POSITION, next_cell))
    stay_if_blocked(agent(s.domain.var, inner, w), target, w)
    settle(s, AGENTS, target, w)


def nobody_moves(s: ir.Move, w: Writer) -> None:
    """Writes a movement phase of a domain that has no members on this map."""
    sort = s.domain.var.sort
    if w.module.stores_moved(sort):
        attribute = attribute_of("moved", sort)
        w.assign(attribute, call("jnp.zeros_like", path(f"state.{attribute}")))


def settle(s: ir.Move, sort: ir.Sort, target: Name, w: Writer) -> None:
    """Writes where agents, or the movers of a sort, stand after all of them have wanted their targets."""
    position = state_reads.positions(w, sort)
    if w.module.game.movers:  # others stay, so whoever wants their cells stays as well
        w.set(
            target,
            Where(
                call("is_one_of", target, state_reads.all_positions(w, but=sort)), position, target
            ),
        )
    bits = call("random_bits", KEY, w.stream(s.stream), w.module.extent(sort))
    w.assign(attribute_of("position", sort), call("resolve", position, target, bits))
    if w.module.stores_moved(sort):
        w.assign(
            attribute_of("moved", sort),
            Binary("!=", w.current(attribute_of("position", sort)), position),
        )


def stay_if_blocked(body: AgentVar, target: Name, w: Writer) -> None:
    """Cells that block only in some states: who wants to enter stays."""
    position = state_reads.positions(w, body.sort)
    for block, kind in conditional_blocks(body.sort.plural, w):
        if body.axis is None:
            raise NotSupported(
                "`move each` of agents named one by one where cells block under a condition",
                w.origin,
            )
        blocked = blocked_by(block, kind, Value(target, "i32", (body.axis,)), w, body)
        moves = Value(Binary("!=", target, position), "bool", (body.axis,))
        w.set(target, Where(binary("&", blocked, moves, "bool").node, position, target))
        w.forget()


def move_on_course(s: ir.Move, scope: IterationScope, w: Writer) -> None:
    """Writes a phase in which movers go: along a heading, or to one of the open cells beside them."""
    course = s.course
    assert course is not None
    inner = enter(s.domain, scope, w)
    mover = agent(s.domain.var, inner, w)
    if mover.axis is None:
        raise NotSupported(
            "`move each` of movers that are named one by one",
            s.origin,
            "say with `where` which of them move",
        )
    axis, position = mover.axis, state_reads.positions(w, mover.sort)
    match course:
        case ir.Along():
            heading = to_words(
                w.value(course.heading, inner.always()), course.heading.type.words, HEADINGS, w
            )
            way, goes = (
                w.keep("way", as_dtype(Value(spread(heading, (axis,)), "u8", (axis,)), "i32")),
                inner.mask,
            )
        case ir.Wander():
            way, goes = _open_way(course, inner, mover, w)
    beside = Index(
        _next_table(mover.sort, w), (Binary("+", Binary("*", position, Literal(4)), way.node),)
    )
    target = w.bind(
        "target", beside if goes == TRUE else Where(spread(goes, (axis,)), beside, position)
    )
    if isinstance(course, ir.Along):
        stay_if_blocked(mover, target, w)
    read = course.heading if isinstance(course, ir.Along) else None
    if not (
        isinstance(read, ir.FieldRead) and (read.held_by.what, read.name) == ("mover", "heading")
    ):  # who looks there already
        attribute, turned = attribute_of("heading", mover.sort), Cast(way.node, "u8")
        w.assign(
            attribute,
            turned
            if goes == TRUE
            else Where(spread(goes, (axis,)), turned, path(f"state.{attribute}")),
        )
    settle(s, mover.sort, target, w)


def _next_table(sort: ir.Sort, w: Writer) -> Name:
    comment = f"where a step leads {sort.name}, by cell and direction; the cell itself if blocked"
    return w.module.constant(
        f"next_cell_of_{sort.name}", w.module.layout.next_table(sort.name), comment
    )


def _open_way(
    course: ir.Wander, scope: IterationScope, mover: AgentVar, w: Writer
) -> tuple[Value, Value]:
    """Returns in which direction each mover goes, one of those open to it by lot, and whether it goes at all."""
    assert mover.axis is not None
    axis, ways = mover.axis, w.axis("way", 4)
    position = Index(state_reads.positions(w, mover.sort), (ALL, NEW_AXIS))
    each_way = Binary(
        "+", Binary("*", position, Literal(4)), Index(iota(ways).node, (NEW_AXIS, ALL))
    )
    beside = w.keep(
        "beside", Value(Index(_next_table(mover.sort, w), (each_way,)), "i32", (axis, ways))
    )
    taken = call("is_one_of", beside.node, state_reads.all_positions(w))
    open_ = Value(
        Binary("&", Binary("!=", beside.node, position), Unary("~", taken)), "bool", (axis, ways)
    )
    for block, kind in conditional_blocks(mover.sort.plural, w):
        open_ = binary("&", open_, invert(blocked_by(block, kind, beside, w, mover)), "bool")
    if course.avoided is not None and not is_empty(course.avoided, w):
        cells, member = _members(course.avoided, scope, axis, w)
        avoided = Where(member, cells, Literal(-1))  # a row of cells for each mover
        within = call("is_one_of", beside.node, Index(avoided, (ALL, NEW_AXIS, ALL)))
        open_ = binary("&", open_, Value(Unary("~", within), "bool", (axis, ways)), "bool")
    if course.goal is not None:
        better = _better(course.goal, course.away, scope, mover, axis, w)
        open_ = binary("&", open_, Value(better, "bool", (axis, ways)), "bool")
    way, found = Name(w.names.fresh("way")), Name(w.names.fresh("found"))
    bits = call("random_bits", KEY, w.stream(course.stream), w.module.extent(mover.sort))
    w.unpack((way, found), call("pick", open_.node, bits))
    return Value(way, "i32", (axis,)), w.keep(
        "goes", both(scope.mask, Value(found, "bool", (axis,)))
    )


def _better(
    goal: ir.Domain, away: bool, scope: IterationScope, mover: AgentVar, axis: Axis, w: Writer
) -> Expression:
    """Returns which of the cells beside each mover are nearer to the nearest member of a goal, or farther from it: `[M, 4]` bool."""
    if is_empty(goal, w):
        return call("jnp.zeros", Sequence((axis.extent, Literal(4))), Name("bool"))
    cells, member = _members(goal, scope, axis, w)
    layout = w.module.layout
    given = (
        state_reads.positions(w, mover.sort),
        cells,
        member,
        w.module.number("frame_cols", layout.cols),
    )
    around = (Literal(layout.height), Literal(layout.width)) if layout.wraps else ()
    gained = call("gains_around" if layout.wraps else "gains", *given, *around)
    return Binary(">" if away else "<", gained, Literal(0))


def _members(
    d: ir.Domain, scope: IterationScope, axis: Axis, w: Writer
) -> tuple[Expression, Expression]:
    """Returns the cells of a domain's members for each mover, and which of them are members: `[M, T]`, or `[1, T]` if all have the same."""
    inner = enter(d, scope.always(), w)
    one = inner.variables[d.var.name]
    at = state_reads.cell(one, w) if isinstance(one, CellVar) else state_reads.position(one, w)
    new = next((a for a in inner.axes if a not in scope.axes), None)
    mask = inner.mask
    if new is None:  # the member is determined: one for each mover
        return Index(spread(at, (axis,)), (ALL, NEW_AXIS)), Index(
            spread(mask, (axis,)), (ALL, NEW_AXIS)
        )
    there = mask if mask.axes else Value(spread(mask, (new,)), "bool", (new,))
    return aligned(at, (axis, new)), aligned(there, (axis, new))

"""Lowers the ways that movers go: which of the cells beside them are open, and which of those they want."""

from sjdsl.compiler import ir
from sjdsl.compiler.ir.names import attribute_of
from sjdsl.compiler.lower import state_reads
from sjdsl.compiler.lower.axes import TRUE, Axis, Value, aligned, as_dtype, binary, both, invert, iota, spread
from sjdsl.compiler.lower.domains import blocked_by, enter, is_empty
from sjdsl.compiler.lower.draws import KEY
from sjdsl.compiler.lower.entries import to_words
from sjdsl.compiler.lower.movement import blocks_of, conditional_blocks, settle
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
    path,
)
from sjdsl.runtime.actions import HEADINGS


def move_on_course(s: ir.Move, scope: IterationScope, w: Writer) -> None:
    """Writes a phase in which movers go: along a heading, or to one of the open cells beside them."""
    course = s.course
    assert course is not None
    inner = enter(s.domain, scope, w)
    mover = inner.variables[s.domain.var.name]
    assert isinstance(mover, AgentVar)
    if mover.axis is None:
        raise NotSupported("`move each` of movers that are named one by one", s.origin, "say with `where` which of them move")
    axis, position = mover.axis, state_reads.positions(w, mover.sort)
    match course:
        case ir.Along():
            heading = to_words(w.value(course.heading, inner.always()), course.heading.type.words, HEADINGS, w)
            way, goes = w.keep("way", as_dtype(Value(spread(heading, (axis,)), "u8", (axis,)), "i32")), inner.mask
        case ir.Wander():
            way, goes = _open_way(course, inner, mover, w)
    beside = Index(_next_table(mover.sort, w), (Binary("+", Binary("*", position, Literal(4)), way.node),))
    wanted = beside if goes is None else Where(spread(goes, (axis,)), beside, position)
    target = w.bind("target", wanted)
    if isinstance(course, ir.Along):
        conditional_blocks(mover, target, w)
    if not _is_ahead(course):
        attribute, turned = attribute_of("heading", mover.sort), Cast(way.node, "u8")
        w.assign(attribute, turned if goes is None else Where(spread(goes, (axis,)), turned, path(f"state.{attribute}")))
    settle(s, mover.sort, target, w)


def _is_ahead(course: ir.Course) -> bool:
    """Whether movers go where they look, and so keep their headings."""
    match course:
        case ir.Along(heading=ir.FieldRead(held_by=ir.Sort("mover"), name="heading")):
            return True
        case _:
            return False


def _next_table(sort: ir.Sort, w: Writer) -> Name:
    comment = f"where a step leads {sort.name}, by cell and direction; the cell itself if blocked"
    return w.module.constant(f"next_cell_of_{sort.name}", w.module.layout.next_table(sort.name), comment)


def _open_way(course: ir.Wander, scope: IterationScope, mover: AgentVar, w: Writer) -> tuple[Value, Value]:
    """Returns in which direction each mover goes, one of those open to it by lot, and whether it goes at all."""
    assert mover.axis is not None
    axis, ways = mover.axis, w.axis("way", 4)
    position = Index(state_reads.positions(w, mover.sort), (ALL, NEW_AXIS))
    each_way = Binary("+", Binary("*", position, Literal(4)), Index(iota(ways).node, (NEW_AXIS, ALL)))
    beside = w.keep("beside", Value(Index(_next_table(mover.sort, w), (each_way,)), "i32", (axis, ways)))
    everybody = state_reads.all_positions(w)
    assert everybody is not None
    free = Binary("&", Binary("!=", beside.node, position), Unary("~", call("is_one_of", beside.node, everybody)))
    open_ = Value(free, "bool", (axis, ways))
    for block, kind in blocks_of(mover.sort, w):
        open_ = binary("&", open_, invert(blocked_by(block, kind, beside, w, mover)), "bool")
    if course.avoided is not None and not is_empty(course.avoided, w):
        cells, member = _members(course.avoided, scope, axis, w)
        taken = Where(member, cells, Literal(-1))  # a row of cells for each mover
        within = call("is_one_of", beside.node, Index(taken, (ALL, NEW_AXIS, ALL)))
        open_ = binary("&", open_, Value(Unary("~", within), "bool", (axis, ways)), "bool")
    if course.goal is not None:
        better = _better(course.goal, course.away, scope, mover, axis, w)
        open_ = binary("&", open_, Value(better, "bool", (axis, ways)), "bool")
    way, found = Name(w.names.fresh("way")), Name(w.names.fresh("found"))
    bits = call("random_bits", KEY, w.stream(course.stream), w.module.extent(mover.sort))
    w.unpack((way, found), call("pick", open_.node, bits))
    goes = both(scope.mask, Value(found, "bool", (axis,)))
    assert goes is not None
    return Value(way, "i32", (axis,)), w.keep("goes", goes)


def _better(goal: ir.Domain, away: bool, scope: IterationScope, mover: AgentVar, axis: Axis, w: Writer) -> Expression:
    """Returns which of the cells beside each mover are nearer to the nearest member of a goal, or farther from it: `[M, 4]` bool."""
    if is_empty(goal, w):
        return call("jnp.zeros", Sequence((axis.extent, Literal(4))), Name("bool"))
    cells, member = _members(goal, scope, axis, w)
    layout, given = (
        w.module.layout,
        (state_reads.positions(w, mover.sort), cells, member, w.module.number("frame_cols", w.module.layout.cols)),
    )
    if layout.wraps:
        gained = call("gains_around", *given, Literal(layout.height), Literal(layout.width))
    else:
        gained = call("gains", *given)
    return Binary(">" if away else "<", gained, Literal(0))


def _members(d: ir.Domain, scope: IterationScope, axis: Axis, w: Writer) -> tuple[Expression, Expression]:
    """Returns the cells of a domain's members for each mover, and which of them are members: `[M, T]`, or `[1, T]` if all have the same."""
    inner = enter(d, scope.always(), w)
    one = inner.variables[d.var.name]
    at = state_reads.cell(one, w) if isinstance(one, CellVar) else state_reads.position(one, w)
    new = next((a for a in inner.axes if a not in scope.axes), None)
    mask = inner.mask or TRUE
    if new is None:  # the member is determined: one for each mover
        return Index(spread(at, (axis,)), (ALL, NEW_AXIS)), Index(spread(mask, (axis,)), (ALL, NEW_AXIS))
    there = mask if mask.axes else Value(spread(mask, (new,)), "bool", (new,))
    return aligned(at, (axis, new)), aligned(there, (axis, new))

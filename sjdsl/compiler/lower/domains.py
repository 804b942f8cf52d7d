"""Lowers domains: the axis that a quantifier adds, its membership mask, and the cells of shapes."""

from dataclasses import replace
from itertools import combinations

from sjdsl.compiler import ir
from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.lower import state_reads
from sjdsl.compiler.lower.axes import (
    TRUE,
    Axis,
    Value,
    binary,
    both,
    indexed,
    invert,
    iota,
    literal,
    spread,
    union,
)
from sjdsl.compiler.lower.scope import AgentVar, CellVar, IterationScope, NotSupported, Variable
from sjdsl.compiler.lower.writer import Writer
from sjdsl.compiler.program.expressions import (
    ALL,
    NEW_AXIS,
    Binary,
    DType,
    Expression,
    Index,
    Literal,
    Name,
    Sequence,
    call,
    constant,
    reduction,
)


class Swept(Record):
    """The cells of a shape around an anchor: in the frame, along `axis`; `ok`: on the map and reached."""

    cells: Value
    axis: Axis
    ok: Value


def enter(d: ir.Domain, scope: IterationScope, w: Writer) -> IterationScope:
    """Returns the scope inside a domain: one more axis unless the member is determined, its mask and its variables."""
    if isinstance(d.restriction, ir.Among):
        inner = _among(d, d.restriction, scope, w)
    else:
        inner = _cells(d, scope, w) if d.var.sort.what == "cell" else _bodies(d, scope, w)
    if d.on is not None:
        agent = inner.variables[d.var.name]
        assert isinstance(agent, AgentVar)
        site, there = state_reads.site_under(agent, d.on.kinds, w)
        inner = inner.binding(**{d.on.name: CellVar(site, d.on.kinds)}).when(there)
    if d.where is not None:
        inner = inner.when(w.value(d.where, inner.always()))
    return inner


def is_empty(d: ir.Domain, w: Writer) -> bool:
    """Returns whether nobody can ever be a member, because the map has no cell of a kind; tables of such cells have no entries."""
    kinds = ([d.var.kinds] if d.var.sort.what == "cell" else []) + (
        [d.on.kinds] if d.on is not None else []
    )
    return not all(map(w.module.layout.num_cells, kinds))


def in_set(members: Value, axis: Axis) -> Value:
    """Returns which agents, along an axis, are in a set that is kept as bits, of a large one in several words."""
    assert all(axis.order > a.order for a in members.axes)
    return Value(
        call("unpack" if members.levels else "from_bits", members.node, axis.extent),
        "bool",
        (*members.axes, axis),
    )


def whole_set(d: ir.Domain, scope: IterationScope, w: Writer) -> Value | None:
    """Returns the set that a domain is, as bits, if it is nothing but a set of agents none of whom can be away."""
    if (
        not isinstance(d.restriction, ir.InAgents)
        or d.restriction.value.type.kind != "agents"
        or d.on
        or d.where
        or w.module.can_be_away()
    ):
        return None
    return w.value(d.restriction.value, scope.always())


def extended(
    scope: IterationScope,
    axis: Axis | None,
    d: ir.Domain,
    variable: Variable,
    digit: Value,
    radix: Literal,
) -> IterationScope:
    """Returns the scope with one more quantifier around it."""
    return replace(
        scope.binding(**{d.var.name: variable}),
        axes=scope.axes if axis is None else (*scope.axes, axis),
        digits=(*scope.digits, (digit, radix)),
    )


def _bodies(d: ir.Domain, scope: IterationScope, w: Writer) -> IterationScope:
    n = w.module.extent(d.var.sort)
    if isinstance(d.restriction, ir.InAgents) and d.restriction.value.type.kind in (
        "agent",
        "member",
    ):
        index = w.keep(d.var.name, w.value(d.restriction.value, scope))
        variable = AgentVar(index)
        inner = extended(scope, None, d, variable, index, n)
        return inner.when(binary(">=", index, literal(0, "i32"), "bool")).when(
            state_reads.present(variable, w)
        )
    axis = w.axis(d.var.name, n)
    variable = AgentVar(iota(axis), axis, d.var.sort)
    inner = extended(scope, axis, d, variable, variable.index, n).when(
        state_reads.present(variable, w)
    )
    match d.restriction:
        case ir.Near():
            return inner.when(agents_in(d.restriction, variable, inner, w))
        case ir.InAgents():
            return inner.when(in_set(w.value(d.restriction.value, scope), axis))
        case _:
            return inner


def _among(d: ir.Domain, among: ir.Among, scope: IterationScope, w: Writer) -> IterationScope:
    """`each agent as one in { a, b }`: an axis over the named variables; one agent or cell named twice counts once."""
    axis = w.axis(d.var.name, len(among.members))
    indices = [number_in(d, scope.variables[m.name], w) for m in among.members]
    axes = union(*(i.axes for i in indices))
    parts = Sequence(tuple(spread(i, axes) for i in indices), is_list=True)
    index = w.keep(
        d.var.name, Value(call("jnp.stack", parts, axis=Literal(len(axes))), "i32", (*axes, axis))
    )
    variable = (
        CellVar(index, d.var.kinds)
        if d.var.sort.what == "cell"
        else AgentVar(index, sort=d.var.sort)
    )
    there = (
        state_reads.is_site(index, d.var.kinds, w)
        if isinstance(variable, CellVar)
        else state_reads.present(variable, w)
    )
    inner = extended(scope, axis, d, variable, index, w.module.extent(d.var.sort)).when(there)
    for earlier, later in sorted(combinations(range(len(indices)), 2), key=lambda pair: pair[::-1]):
        is_later = binary("==", iota(axis), literal(later, "i32"), "bool")
        same = binary("==", indices[later], indices[earlier], "bool")
        inner = inner.when(invert(both(is_later, same)))
    return inner


def number_in(d: ir.Domain, member: Variable, w: Writer) -> Value:
    """Returns the number of a variable among all that a domain may have; past the end of a cell of another kind."""
    if isinstance(member, AgentVar):
        return member.number
    if member.kinds == d.var.kinds:
        return state_reads.placed(member, w).number
    return state_reads.site_at(state_reads.cell(member, w), d.var.kinds, w)


def _cells(d: ir.Domain, scope: IterationScope, w: Writer) -> IterationScope:
    if isinstance(d.restriction, ir.Near):
        site, axis, ok = sites_in(d.restriction, d.var.kinds, scope, w, d.var.name)
        return extended(scope, axis, d, CellVar(site, d.var.kinds), iota(axis), axis.extent).when(
            ok
        )
    if isinstance(d.restriction, ir.InCell):
        held = state_reads.held_cell(d.restriction.value, d.var.kinds, scope, w)
        inner = extended(scope, None, d, held, held.site, w.module.num_cells(d.var.kinds))
        return inner.when(state_reads.is_site(held.site, d.var.kinds, w))
    axis = w.axis(d.var.name, w.module.num_cells(d.var.kinds))
    variable = CellVar(iota(axis), d.var.kinds, axis)
    return extended(scope, axis, d, variable, variable.site, axis.extent)


def sites_in(
    near: ir.Near, kinds: tuple[str, ...], scope: IterationScope, w: Writer, name: str
) -> tuple[Value, Axis, Value]:
    """Returns the numbers (among `kinds`) of a shape's cells around an anchor, their axis, and which are there."""
    anchor = scope.variables[near.anchor.name]
    shape = w.module.shape(near.shape)
    if isinstance(anchor, CellVar):
        anchor = state_reads.placed(anchor, w)
        axis = w.axis(name, sum(map(len, shape.lanes)))
        constant = neighbours_constant(near, anchor, kinds, w)
        node = constant if anchor.axis is not None else Index(constant, (anchor.site.node,))
        site = Value(node, "i32", (*anchor.site.axes, axis))
        return site, axis, state_reads.is_site(site, kinds, w)
    swept = sweep(near, scope, w)
    site = w.keep(
        f"{near.shape.split('(')[0]}_{'_'.join(kinds)}", state_reads.site_at(swept.cells, kinds, w)
    )
    return (
        site,
        swept.axis,
        both(state_reads.is_site(site, kinds, w), swept.ok if has_inner_blocks(shape, w) else TRUE),
    )


def neighbours_constant(near: ir.Near, anchor: CellVar, kinds: tuple[str, ...], w: Writer) -> Name:
    """Returns the table of the numbers (among `kinds`) of a shape's cells around each cell of the anchor's kinds."""
    shape = w.module.shape(near.shape)
    table = w.module.layout.neighbours_table(anchor.kinds, shape, kinds)
    label = f"{near.shape.split('(')[0]}_{'_'.join(kinds)}"
    return w.module.constant(
        label,
        table,
        f"cells of {', '.join(kinds)} in {shape.name} of each cell; past the end: none",
    )


def has_inner_blocks(shape: ir.Shape, w: Writer) -> bool:
    """Whether some cell of the map ends a lane of the shape; off the map there is nothing to be shielded."""
    if shape.see_through or not any(len(lane) > 1 for lane in shape.lanes):
        return False
    return (
        _by_state(shape, w)
        or w.module.layout.count(w.module.layout.blocking_glyphs(shape.name)) > 0
    )


def _by_state(shape: ir.Shape, w: Writer) -> bool:
    """Whether the state decides where a lane of the shape ends: a condition on cells, or agents in the way."""
    cells = any(
        b.what == shape.name and b.condition is not None
        for k in w.module.game.kinds
        for b in k.blocks
    )
    return cells or any(b.what == shape.name for b in w.module.game.agents.blocks)


def shape_name(shape: str) -> str:
    """Returns a shape as a part of names: `disc(2)` is `disc_2`."""
    return "_".join("".join(c if c.isalnum() else " " for c in shape).split())


def sweep(near: ir.Near, scope: IterationScope, w: Writer) -> Swept:
    """Returns the cells of a shape around an agent or a cell, such as a beam's, up to what blocks it."""
    anchor = scope.variables[near.anchor.name]
    shape = w.module.shape(near.shape)
    offsets = w.module.layout.offsets_table(shape)
    ident = shape_name(near.shape)
    name = w.module.constant(
        f"{ident}_offsets", offsets, f"cells of {shape.name} from an agent's cell, for each heading"
    )
    if (
        (ident, anchor) not in w.shape_axes
    ):  # one axis a shape and anchor, so that cells found twice are the same array
        size = w.module.number(
            f"num_{ident}_cells", sum(map(len, shape.lanes)), "cells of the shape"
        )
        w.shape_axes[ident, anchor] = w.axis(ident, size)
    axis = w.shape_axes[ident, anchor]
    if isinstance(anchor, AgentVar):
        at, facing = state_reads.position(anchor, w), state_reads.heading(anchor, w)
    else:  # a cell has no heading, and the shapes around cells have no direction
        at, facing = state_reads.cell(anchor, w), literal(0, "i32")
    step = Value(
        Index(name, (Literal(0) if shape.see_through else facing.node,)),
        "i32",
        (axis,) if shape.see_through else (*at.axes, axis),
    )
    cells = w.keep(f"{ident}_cells", _plus(at, step, axis, w))
    ok = _reached(shape, ident, at, facing, cells, axis, w)
    if any(
        a.order >= axis.order for a in scope.axes
    ):  # the same shape of the same agent once more inside itself, or in a later statement
        other = replace(w.axis(ident, axis.size), constant=axis.constant)
        cells, ok = (
            replace(v, axes=tuple(other if a == axis else a for a in v.axes)) for v in (cells, ok)
        )
        axis = other
    return Swept(cells, axis, ok)


def _plus(at: Value, step: Value, axis: Axis, w: Writer) -> Value:
    """Returns cells with the steps to each cell of a shape added; the shape's axis comes last, whenever it was made."""
    axes = (*at.axes, axis)
    lead = Index(at.node, (*[ALL] * len(at.axes), NEW_AXIS)) if at.axes else at.node
    tail = Index(step.node, (*[NEW_AXIS] * len(at.axes), ALL)) if step.axes != axes else step.node
    return state_reads.on_map(Value(Binary("+", lead, tail), "i32", axes), w)


def _reached(
    shape: ir.Shape, ident: str, at: Value, facing: Value, cells: Value, axis: Axis, w: Writer
) -> Value:
    """Returns which of the cells are on the map and not behind a cell that blocks the shape."""
    inside = w.module.constant(
        "inside", w.module.layout.inside_table, "cells of the map in the frame"
    )
    on_map = Value(Index(inside, (cells.node,)), "bool", cells.axes)
    if not has_inner_blocks(shape, w):
        return on_map
    if _by_state(shape, w):
        return w.keep(f"{ident}_reached", _walked(shape, on_map, cells, w))
    if axis.size > 32:
        what = f"a shape of {axis.size} cells that something on the map blocks (at most 32)"
        raise NotSupported(what, shape.origin, "make it smaller, or let nothing block it")
    dtype: DType = "u8" if axis.size <= 8 else "u32"
    comment = f"cells of {shape.name} not behind what blocks it: bits by cell and heading"
    table = w.module.constant(f"{ident}_reach", w.module.layout.reach_table(shape), comment)
    entry = binary(
        "+", binary("*", at, literal(4, "i32"), "i32"), replace(facing, axes=at.axes), "i32"
    )
    bits = w.keep(f"{ident}_bits", Value(Index(table, (entry.node,)), dtype, at.axes))
    return w.keep(
        f"{ident}_reached",
        Value(call("from_bits", bits.node, axis.extent), "bool", (*at.axes, axis)),
    )


def _walked(shape: ir.Shape, on_map: Value, cells: Value, w: Writer) -> Value:
    """Lanes that may end at cells whose state decides: walked cell by cell."""
    layout = w.module.layout
    fixed = w.module.constant(
        f"blocks_{shape.name}",
        layout.blocking_table(shape.name),
        f"cells that always block {shape.name}",
    )
    blocked = Value(Index(fixed, (cells.node,)), "bool", cells.axes)
    for condition, kind in conditional_blocks(shape.name, w):
        blocked = binary("|", blocked, blocked_by(condition, kind, cells, w), "bool")
    for block in w.module.game.agents.blocks:
        if block.what == shape.name:
            blocked = binary("|", blocked, _agents_block(block, cells, w), "bool")
    blocked = w.keep(f"{shape.name}_blocked", blocked)
    starts = constant([at == 0 for lane in shape.lanes for at in range(len(lane))])
    first = w.module.constant(
        f"{shape.name}_starts", starts, f"first cells of the lanes of {shape.name}", "bool"
    )
    return Value(call("reached", blocked.node, on_map.node, first), "bool", cells.axes)


def _agents_block(block: ir.Block, cells: Value, w: Writer) -> Value:
    """Returns on which of the cells an agent stands that ends lanes."""
    standing = stand_on(cells, state_reads.positions(w))
    if block.condition is not None:
        axis = w.axis("blocker", w.module.agents)
        scope = IterationScope(axes=(axis,), variables={"agent": AgentVar(iota(axis), axis)})
        stops = Index(
            spread(w.value(block.condition, scope), (axis,)), (*(NEW_AXIS for _ in cells.axes), ALL)
        )
        standing = Binary("&", standing, stops)
    return Value(reduction("any", standing, (len(cells.axes),)), "bool", cells.axes)


def conditional_blocks(what: str, w: Writer) -> list[tuple[ir.Block, ir.Kind]]:
    """Returns what blocks agents, a sort of movers or a shape under conditions, each with the kind of the cells."""
    kinds = [kind for kind in w.module.game.kinds if w.module.layout.num_cells((kind.name,))]
    return [
        (block, kind)
        for kind in kinds
        for block in kind.blocks
        if block.what == what and block.condition is not None
    ]


def blocked_by(
    block: ir.Block, kind: ir.Kind, cells: Value, w: Writer, agent: AgentVar | None = None
) -> Value:
    """Returns which of the cells are of a kind and block, by the state of the snapshot."""
    site = state_reads.site_at(cells, (kind.name,), w)
    if agent is None and any(
        isinstance(n, ir.Member) and n.sort.what == "agent" for n in ir.walk(block)
    ):
        what = "a shape blocked by a condition on the agent"
        raise NotSupported(
            what,
            block.origin,
            "`blocks agents` may ask about the agent; what blocks a shape asks about the cell alone",
        )
    variables: dict[str, Variable] = {kind.name: CellVar(site, (kind.name,))}
    if agent is not None:
        variables[agent.sort.name] = agent
    assert block.condition is not None
    test = w.value(block.condition, IterationScope(axes=cells.axes, variables=variables))
    return both(state_reads.is_site(site, (kind.name,), w), test)


def agents_in(near: ir.Near, variable: AgentVar, scope: IterationScope, w: Writer) -> Value:
    """Returns which agents stand on a cell of the shape."""
    anchor = scope.variables[near.anchor.name]
    shape = w.module.shape(near.shape)
    assert variable.axis is not None
    if isinstance(anchor, CellVar):
        around = Index(w.module.layout.offsets_table(shape), (Literal(0),))
        offsets = w.module.constant(
            f"{shape.name.split('(')[0]}_around", around, f"cells of {shape.name}"
        )
        axis = w.axis("around", sum(map(len, shape.lanes)))
        cells, ok = (
            _plus(state_reads.cell(anchor, w), Value(offsets, "i32", (axis,)), axis, w),
            TRUE,
        )
    else:
        swept = sweep(near, scope, w)
        cells, ok = swept.cells, swept.ok if has_inner_blocks(shape, w) else TRUE
    axes = (*cells.axes[:-1], variable.axis) if variable.axis not in cells.axes else cells.axes[:-1]
    here = stand_on(cells, state_reads.position(variable, w).node)
    if ok != TRUE:
        here = Binary("&", here, Index(ok.node, (*[ALL] * len(ok.axes), NEW_AXIS)))
    return w.keep(
        f"in_{shape_name(near.shape)}",
        Value(reduction("any", here, (len(cells.axes) - 1,)), "bool", axes),
    )


def stand_on(cells: Value, position: Expression) -> Expression:
    """Returns who stands on which cells: an axis more, for the agents, after those of the cells."""
    each_cell = indexed(cells.node, (*[ALL] * len(cells.axes), NEW_AXIS))
    return Binary("==", each_cell, Index(position, (*[NEW_AXIS] * len(cells.axes), ALL)))

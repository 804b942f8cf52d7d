"""Lowers domains: the axis that a quantifier adds, its membership mask, and the cells of shapes.

    each water in beam of cleaner where water.state is dirty { ... }

adds an axis for the cells of the beam, a variable `water` whose numbers are the sites under them,
and a mask: there is a cell of water, and it is dirty.
"""

import re
from dataclasses import replace

from sjdsl.compiler import ir
from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.lower import state_reads
from sjdsl.compiler.lower.axes import (
    TRUE,
    Axis,
    Value,
    axes_of,
    broadcast,
    called,
    indexed,
    iota,
    literal,
    looked_up,
    reduce,
    spread,
)
from sjdsl.compiler.lower.scope import (
    AgentVar,
    CellVar,
    IterationScope,
    NotSupported,
    Variable,
    numbered,
    scope_of_agents,
)
from sjdsl.compiler.lower.writer import Writer
from sjdsl.compiler.program.expressions import (
    ALL,
    NEW_AXIS,
    DType,
    Expression,
    Name,
    call,
    reduction,
)


class Swept(Record):
    """The cells of a shape around an anchor.

    cells: in the frame, along the last axis. is_reached: which of them are on the map, and not
      behind a cell that blocks the shape. unblocked: the same, but TRUE if nothing on this map
      blocks it: enough for cells on which something is, as that is on the map.
    """

    cells: Value
    is_reached: Value
    unblocked: Value


def enter(d: ir.Domain, scope: IterationScope, w: Writer) -> IterationScope:
    """Returns the scope inside a domain, with its variables and its mask.

    It has one more axis, unless the domain has exactly one candidate.
    """
    if isinstance(d.restriction, ir.Among):
        inner = _among(d, d.restriction, scope, w)
    elif d.var.entity_type.what == "cell":
        inner = _cells(d, scope, w)
    else:
        inner = _bodies(d, scope, w)
    if d.on is not None:
        agent = inner.variables[d.var.name]
        assert isinstance(agent, AgentVar)
        site, is_on = state_reads.site_under(agent, d.on.kinds, w)
        inner = inner.binding(d.on.name, CellVar(site, d.on.kinds)).when(is_on)
    if d.where is not None:
        inner = inner.when(w.value(d.where, inner))
    return inner


def is_empty(d: ir.Domain, w: Writer) -> bool:
    """Returns whether a domain can have no member, because the map has no cell of a kind.

    Tables of such cells have no entries.
    """
    num_cells = w.layout.num_cells
    if d.on is not None and not num_cells(d.on.kinds):
        return True
    return d.var.entity_type.what == "cell" and not num_cells(d.var.kinds)


def agents_in_sets(sets: Value, axis: Axis) -> Value:
    """Returns whether each agent is in sets kept as bits, along a new last axis of agents."""
    assert all(axis.order > other.order for other in sets.axes)
    kernel = "unpack" if sets.row_dims else "from_bits"
    return Value(call(kernel, sets.node, axis.extent), "bool", (*sets.axes, axis))


def whole_set(d: ir.Domain, scope: IterationScope, w: Writer) -> Value | None:
    """Returns a domain such as `agent in water.cleaners` as the set it is, kept as bits.

    None if it has another condition, or a member may be away, who doesn't count.
    """
    if not isinstance(d.restriction, ir.InAgents) or d.on or d.where or w.module.can_be_away():
        return None
    if d.restriction.value.type.kind != "agents":
        return None
    return w.value(d.restriction.value, scope)


def extended(
    scope: IterationScope,
    axis: Axis | None,
    d: ir.Domain,
    variable: Variable,
    w: Writer,
    is_place: bool = False,
) -> IterationScope:
    """Returns the scope inside one more quantifier.

    Args:
      axis: of the quantifier; None if it has one candidate.
      is_place: whether random draws number its members by their places along the axis, not by their
        numbers among all of their type.
    """
    digit = (variable.number, w.module.extent(d.var.entity_type))
    if is_place and axis is not None:
        digit = (iota(axis), axis.extent)
    axes = scope.axes if axis is None else (*scope.axes, axis)
    inner = scope.binding(d.var.name, variable)
    return replace(inner, axes=axes, digits=(*scope.digits, digit))


def _bodies(d: ir.Domain, scope: IterationScope, w: Writer) -> IterationScope:
    """Returns the scope inside a domain of agents or movers."""
    match d.restriction:
        case ir.InAgents(value=value) if value.type.kind in ("agent", "member"):
            index = w.keep(d.var.name, w.value(value, scope))
            variable = AgentVar(index)
            inner = extended(scope, None, d, variable, w)
            inner = inner.when(index >= 0)
            return inner.when(state_reads.present(variable, w))
    axis = w.axis(d.var.name, w.module.extent(d.var.entity_type))
    variable = AgentVar(iota(axis), axis, d.var.entity_type)
    inner = extended(scope, axis, d, variable, w)
    inner = inner.when(state_reads.present(variable, w))
    match d.restriction:
        case ir.Near():
            return inner.when(agents_in(d.restriction, variable, inner, w))
        case ir.InAgents(value=value):
            return inner.when(agents_in_sets(w.value(value, scope), axis))
        case _:
            return inner


def _among(d: ir.Domain, among: ir.Among, scope: IterationScope, w: Writer) -> IterationScope:
    """Returns the scope inside `each agent as one in { a, b }`, with an axis over the variables.

    One agent or cell that is named twice counts once.
    """
    axis = w.axis(d.var.name, len(among.members))
    numbers = [number_in(d, scope.variables[member.name], w) for member in among.members]
    axes = axes_of(*numbers)
    stacked = call("jnp.stack", [spread(number, axes) for number in numbers], axis=len(axes))
    along_axis = w.keep(d.var.name, Value(stacked, "i32", (*axes, axis)))
    variable = numbered(d.var, along_axis)
    inner = extended(scope, axis, d, variable, w)
    if isinstance(variable, CellVar):
        inner = inner.when(state_reads.is_site(along_axis, d.var.kinds, w))
    else:
        inner = inner.when(state_reads.present(variable, w))
    for place, later in enumerate(numbers):
        for earlier in numbers[:place]:
            is_repeated = iota(axis).eq(place) & later.eq(earlier)
            inner = inner.when(~is_repeated)
    return inner


def number_in(d: ir.Domain, member: Variable, w: Writer) -> Value:
    """Returns the number of a variable among all candidates of a domain.

    For a cell of another kind it is past the end.
    """
    if isinstance(member, AgentVar):
        return member.number
    if member.kinds == d.var.kinds:
        return state_reads.placed(member, w).number
    return state_reads.site_at(state_reads.cell(member, w), d.var.kinds, w)


def _cells(d: ir.Domain, scope: IterationScope, w: Writer) -> IterationScope:
    """Returns the scope inside a domain of cells."""
    kinds = d.var.kinds
    match d.restriction:
        case ir.Near():
            site, exists = sites_in(d.restriction, kinds, scope, w, d.var.name)
            axis = site.axes[-1]
            inner = extended(scope, axis, d, CellVar(site, kinds), w, is_place=True)
            return inner.when(exists)
        case ir.InCell(value=value):
            held = state_reads.held_cell(value, kinds, scope, w)
            inner = extended(scope, None, d, held, w)
            return inner.when(state_reads.is_site(held.number, kinds, w))
        case _:
            axis = w.axis(d.var.name, w.module.num_cells(kinds))
            variable = CellVar(iota(axis), kinds, axis)
            return extended(scope, axis, d, variable, w)


def sites_in(
    near: ir.Near, kinds: tuple[str, ...], scope: IterationScope, w: Writer, name: str
) -> tuple[Value, Value]:
    """Returns the sites of `kinds` at the cells of a shape around an anchor, and which exist.

    Both have the cells of the shape along their last axis. name: of that axis.
    """
    anchor = scope.variables[near.anchor.name]
    shape = w.module.shape(near.shape)
    if isinstance(anchor, CellVar):
        anchor = state_reads.placed(anchor, w)
        axis = w.axis(name, shape.num_cells)
        table = neighbours_constant(near, anchor, kinds, w)
        neighbours = table if anchor.axis is not None else table[anchor.number.node]
        site = Value(neighbours, "i32", (*anchor.number.axes, axis))
        return site, state_reads.is_site(site, kinds, w)
    swept = sweep(near, scope, w)
    numbers = state_reads.site_at(swept.cells, kinds, w)
    site = w.keep(_site_name(near, kinds), numbers)
    return site, state_reads.is_site(site, kinds, w) & swept.unblocked


def neighbours_constant(near: ir.Near, anchor: CellVar, kinds: tuple[str, ...], w: Writer) -> Name:
    """Returns the table of a shape's cells around each cell, by number among `kinds`."""
    shape = w.module.shape(near.shape)
    table = w.layout.neighbours_table(anchor.kinds, shape, kinds)
    comment = f"cells of {', '.join(kinds)} in {shape.name} of each cell; past the end: none"
    return w.module.constant(_site_name(near, kinds), table, comment)


def _site_name(near: ir.Near, kinds: tuple[str, ...]) -> str:
    return f"{near.shape.split('(')[0]}_{'_'.join(kinds)}"


def has_inner_blocks(shape: ir.Shape, w: Writer) -> bool:
    """Returns whether a cell of the map may end a lane of the shape before the lane's last cell."""
    if shape.see_through or not any(len(lane) > 1 for lane in shape.lanes):
        return False
    layout = w.layout
    return _has_changing_blocks(shape, w) or layout.count(layout.blocking_glyphs(shape.name)) > 0


def shape_name(shape: str) -> str:
    """Returns a shape as a part of names: `disc(2)` is `disc_2`."""
    return "_".join(re.findall(r"[^\W_]+", shape))


def _has_changing_blocks(shape: ir.Shape, w: Writer) -> bool:
    """Returns whether agents, or cells under a condition, may end a lane of the shape."""
    by_agents = any(b.what == shape.name for b in w.game.agents.blocks)
    return by_agents or bool(conditional_blocks(shape.name, w))


def sweep(near: ir.Near, scope: IterationScope, w: Writer) -> Swept:
    """Returns the cells of a shape around an agent or a cell: `beam of zapper`, `disc(2) of tree`.

        beam_cells = state.position[:, None] + BEAM_OFFSETS[state.heading]

    All sweeps of one shape around one anchor in a function share one axis, and so one array.
    """
    anchor = scope.variables[near.anchor.name]
    shape = w.module.shape(near.shape)
    offsets = w.layout.offsets_table(shape)
    prefix = shape_name(near.shape)  # of names in generated code
    comment = f"cells of {shape.name} from an agent's cell, for each heading"
    table = w.module.constant(f"{prefix}_offsets", offsets, comment)
    if (prefix, anchor) not in w.shape_axes:
        size = w.module.number(f"num_{prefix}_cells", shape.num_cells, "cells of the shape")
        w.shape_axes[prefix, anchor] = w.axis(prefix, size)
    axis = w.shape_axes[prefix, anchor]
    location = state_reads.location(anchor, w)
    if isinstance(anchor, AgentVar):
        heading = state_reads.heading(anchor, w)
    else:  # a cell has no heading, and the shapes around cells have no direction
        heading = literal(0, "i32")
    if shape.see_through:  # such a shape looks the same for all headings
        steps = Value(table[0], "i32", (axis,))
    else:
        steps = Value(table[heading.node], "i32", (*location.axes, axis))
    cells = w.keep(f"{prefix}_cells", _cells_around(location, steps, w))
    is_reached = _reached(shape, location, heading, cells, w)
    if any(other.order >= axis.order for other in scope.axes):
        # The shape was first swept outside of a quantifier of this scope, or by it. Axes are in the
        # order of quantifiers, so it gets another axis.
        renamed = replace(w.axis(prefix, axis.size), constant=axis.constant)
        cells = _with_axis(cells, axis, renamed)
        is_reached = _with_axis(is_reached, axis, renamed)
    return Swept(cells, is_reached, is_reached if has_inner_blocks(shape, w) else TRUE)


def _with_axis(value: Value, axis: Axis, renamed: Axis) -> Value:
    return replace(value, axes=tuple(renamed if a == axis else a for a in value.axes))


def _cells_around(location: Value, steps: Value, w: Writer) -> Value:
    """Returns the cells of a shape around each location, with the shape's axis last.

    steps: from a location to each cell of the shape, for each location or for all.
    """
    axes = (*location.axes, steps.axes[-1])
    lead = location.node
    if location.axes:
        lead = lead[*[ALL] * len(location.axes), None]
    tail = steps.node
    if steps.axes != axes:
        tail = tail[*[NEW_AXIS] * len(location.axes), :]
    return state_reads.on_map(Value(lead + tail, "i32", axes), w)


def _reached(shape: ir.Shape, location: Value, heading: Value, cells: Value, w: Writer) -> Value:
    """Returns which cells of a shape are on the map, and not behind one that blocks the shape.

    Args:
      location, heading: of the anchor; cells: of the shape around it.
    Raises:
      NotSupported: a shape of more than 32 cells that the map blocks.
    """
    inside = is_inside(cells, w)
    if not has_inner_blocks(shape, w):
        return inside
    prefix = shape_name(shape.name)
    if _has_changing_blocks(shape, w):
        return w.keep(f"{prefix}_reached", _reached_past_changing(shape, inside, cells, w))
    axis = cells.axes[-1]
    if axis.size > 32:
        feature = f"a shape of {axis.size} cells that something on the map blocks (at most 32)"
        raise NotSupported(feature, shape.origin, "make it smaller, or let nothing block it")
    dtype: DType = "u8" if axis.size <= 8 else "u32"
    comment = f"cells of {shape.name} not behind what blocks it: bits by cell and heading"
    table = w.module.constant(f"{prefix}_reach", w.layout.reach_table(shape), comment)
    bits = w.keep(f"{prefix}_bits", looked_up(table, location * 4 + heading, dtype))
    reached = call("from_bits", bits.node, axis.extent)
    return w.keep(f"{prefix}_reached", Value(reached, "bool", (*location.axes, axis)))


def is_inside(cells: Value, w: Writer) -> Value:
    """Returns which cells of the frame are on the map."""
    table = w.layout.inside_table
    inside = w.module.constant("inside", table, "cells of the map in the frame")
    return looked_up(inside, cells, "bool")


def always_block(cells: Value, name: str, w: Writer) -> Value:
    """Returns which cells always block agents, movers of a name, or a shape."""
    table = w.layout.blocking_table(name)
    fixed = w.module.constant(f"blocks_{name}", table, f"cells that always block {name}")
    return looked_up(fixed, cells, "bool")


def _reached_past_changing(shape: ir.Shape, on_map: Value, cells: Value, w: Writer) -> Value:
    """Returns what `_reached` does if agents, or cells under a condition, block the shape."""
    name = shape.name
    blocked = always_block(cells, name, w)
    for block, kind in conditional_blocks(name, w):
        blocked = blocked | blocked_by(block, kind, cells, w)
    for block in w.game.agents.blocks:
        if block.what == name:
            blocked = blocked | _agents_block(block, cells, w)
    blocked = w.keep(f"{name}_blocked", blocked)
    starts = [place == 0 for lane in shape.lanes for place in range(len(lane))]
    comment = f"first cells of the lanes of {name}"
    first = w.module.constant(f"{name}_starts", starts, comment, "bool")
    return called("reached", blocked, on_map.node, first)


def _agents_block(block: ir.Block, cells: Value, w: Writer) -> Value:
    """Returns on which of the cells an agent stands that blocks a shape."""
    axis = w.axis("blocker", w.module.agents)
    standing = stand_on(cells, state_reads.positions(w))
    blocks = Value(standing, "bool", (*cells.axes, axis))
    if block.condition is not None:
        test = w.value(block.condition, scope_of_agents((axis,)))
        blocks = blocks & broadcast(test, (axis,))
    return reduce("any", blocks, (axis,))


def conditional_blocks(name: str, w: Writer) -> list[tuple[ir.Block, ir.Kind]]:
    """Returns the `blocks X when ...` of all kinds on the map, each with its kind.

    name: what is blocked: "agents", movers in the plural, or a shape.
    """
    pairs = []
    for kind in w.game.kinds:
        is_on_map = w.layout.num_cells((kind.name,)) > 0
        for block in kind.blocks:
            if is_on_map and block.what == name and block.condition is not None:
                pairs.append((block, kind))
    return pairs


def blocked_by(
    block: ir.Block, kind: ir.Kind, cells: Value, w: Writer, agent: AgentVar | None = None
) -> Value:
    """Returns which of the cells are of a kind and block, as their state is before the phase.

    agent: who would enter them, for conditions that ask about it.
    Raises NotSupported for such a condition on what blocks a shape.
    """
    site = state_reads.site_at(cells, (kind.name,), w)
    members = [n for n in ir.walk(block) if isinstance(n, ir.Member)]
    if agent is None and any(member.entity_type.what == "agent" for member in members):
        instead = (
            "`blocks agents` may ask about the agent; what blocks a shape asks about the cell alone"
        )
        feature = "a shape blocked by a condition on the agent"
        raise NotSupported(feature, block.origin, instead)
    variables: dict[str, Variable] = {kind.name: CellVar(site, (kind.name,))}
    if agent is not None:
        variables[agent.entity_type.name] = agent
    assert block.condition is not None
    test = w.value(block.condition, IterationScope(axes=cells.axes, variables=variables))
    return state_reads.is_site(site, (kind.name,), w) & test


def agents_in(near: ir.Near, variable: AgentVar, scope: IterationScope, w: Writer) -> Value:
    """Returns which agents, along the axis of `variable`, stand on a cell of the shape."""
    assert variable.axis is not None
    swept = sweep(near, scope, w)
    cells = swept.cells
    axes = cells.axes[:-1]
    if variable.axis not in cells.axes:
        axes = (*axes, variable.axis)
    standing = stand_on(cells, state_reads.position(variable, w).node)
    if swept.unblocked != TRUE:
        standing = standing & swept.unblocked.node[*[ALL] * len(cells.axes), None]
    inside = Value(reduction("any", standing, (len(cells.axes) - 1,)), "bool", axes)
    return w.keep(f"in_{shape_name(near.shape)}", inside)


def stand_on(cells: Value, position: Expression) -> Expression:
    """Returns who stands on which of the cells: `[..., N]` bool for cells `[...]`.

    position: `[N]`, the cells of agents or movers.
    """
    each_cell = indexed(cells.node, (*[ALL] * len(cells.axes), NEW_AXIS))
    return each_cell.eq(position[*[NEW_AXIS] * len(cells.axes), :])

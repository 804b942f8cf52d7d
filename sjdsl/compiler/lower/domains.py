"""Lowers domains: the axis that a quantifier adds, its membership mask, and the cells of shapes."""

from dataclasses import dataclass, replace

import numpy as np

from sjdsl.compiler import ir
from sjdsl.compiler.lower import state_reads
from sjdsl.compiler.lower.axes import Axis, Value, aligned, binary, both, literal, union, wrapped
from sjdsl.compiler.lower.expressions import lower
from sjdsl.compiler.lower.scope import AgentVar, CellVar, Frame, NotSupported, Writer, iota


@dataclass(frozen=True)
class Swept:
    """The cells of a shape around an anchor: in the frame, along `axis`; `ok`: on the map and reached (None: see member)."""

    cells: Value
    axis: Axis
    ok: Value | None


def enter(d: ir.Domain, frame: Frame, w: Writer) -> Frame:
    """Returns the place inside a domain: one more axis unless the member is determined, its mask and its variables."""
    if d.var.who == "agent":
        inner = _agents(d, frame, w)
    else:
        inner = _cells(d, frame, w)
    if d.on is not None:
        agent = inner.variables[d.var.name]
        assert isinstance(agent, AgentVar)
        site, there = state_reads.site_under(agent, d.on.kinds, w)
        on = CellVar(site, d.on.kinds)
        inner = replace(inner, variables={**inner.variables, d.on.name: on}).when(there)
    if d.where is not None:
        inner = inner.when(lower(d.where, inner.always(), w))
    return inner


def is_empty(d: ir.Domain, w: Writer) -> bool:
    """Returns whether nobody can ever be a member, because the map has no cell of a kind; tables of such cells have no entries."""
    kinds = ([d.var.kinds] if d.var.who == "cell" else []) + ([d.on.kinds] if d.on is not None else [])
    return not all(map(w.module.layout.num_cells, kinds))


def in_set(members: Value, axis: Axis) -> Value:
    """Returns which agents, along an axis, are in a set that is kept as bits."""
    bit = binary("&", binary(">>", members, iota(axis, members.dtype), members.dtype), literal(1, members.dtype), members.dtype)
    return binary("!=", bit, literal(0, members.dtype), "bool")


def whole_set(d: ir.Domain, frame: Frame, w: Writer) -> Value | None:
    """Returns the set that a domain is, as bits, if it is nothing but a set of agents none of whom can be away."""
    if not isinstance(d.place, ir.InAgents) or d.place.value.type.kind != "agents" or d.on or d.where or w.module.can_be_away:
        return None
    return lower(d.place.value, frame.always(), w)


def extended(frame: Frame, axis: Axis | None, d: ir.Domain, variable: AgentVar | CellVar, digit: Value, radix: int) -> Frame:
    """Returns the place with one more quantifier around it."""
    return replace(
        frame,
        axes=frame.axes if axis is None else (*frame.axes, axis),
        digits=(*frame.digits, (digit, radix)),
        variables={**frame.variables, d.var.name: variable},
    )


def _agents(d: ir.Domain, frame: Frame, w: Writer) -> Frame:
    n = w.module.num_agents
    match d.place:
        case ir.InAgents() if d.place.value.type.kind in ("agent", "member"):
            index = w.keep(d.var.name, lower(d.place.value, frame, w))
            variable = AgentVar(index)
            inner = extended(frame, None, d, variable, index, n)
            return inner.when(binary(">=", index, literal(0, "i32"), "bool")).when(state_reads.present(variable, w))
        case ir.Among():
            return _among(d, d.place, frame, w)
        case _:
            pass
    axis = w.axis(d.var.name, n)
    variable = AgentVar(iota(axis), axis)
    inner = extended(frame, axis, d, variable, variable.index, n).when(state_reads.present(variable, w))
    match d.place:
        case ir.Near():
            return inner.when(agents_in(d.place, variable, inner, w))
        case ir.InAgents():
            return inner.when(in_set(lower(d.place.value, frame, w), axis))
        case _:
            return inner


def _among(d: ir.Domain, place: ir.Among, frame: Frame, w: Writer) -> Frame:
    """`each agent as one in { a, b }`: an axis over the named variables; one agent named twice counts once."""
    axis = w.axis(d.var.name, len(place.members))
    if d.var.who != "agent":
        raise NotSupported("a list of cells in braces", d.origin, "write the sentence for each of the cells by itself")
    members = [frame.variables[m.name] for m in place.members]
    indices = [m.index for m in members]  # type: ignore[union-attr]
    axes = union(*(i.axes for i in indices))
    shape = ", ".join(str(a.size) for a in axes)
    parts = ", ".join(f"jnp.broadcast_to({aligned(i, axes)}, ({shape},))" if axes else i.text for i in indices)
    index = w.keep(d.var.name, Value(f"jnp.stack([{parts}], axis={len(axes)})", "i32", (*axes, axis)))
    variable = AgentVar(index)
    inner = extended(frame, axis, d, variable, index, w.module.num_agents).when(state_reads.present(variable, w))
    repeats = []
    for later in range(1, len(indices)):
        for earlier in range(later):
            same = binary("==", indices[later], indices[earlier], "bool")
            number = Value(f"(jnp.arange({axis.size}) == {later})", "bool", (axis,))
            repeats.append(both(number, same))
    for repeat in repeats:
        assert repeat is not None
        inner = inner.when(Value(f"~({repeat.text})", "bool", repeat.axes))
    return inner


def _cells(d: ir.Domain, frame: Frame, w: Writer) -> Frame:
    size = w.module.layout.num_cells(d.var.kinds)
    if isinstance(d.place, ir.Near):
        site, axis, ok = sites_in(d.place, d.var.kinds, frame, w, d.var.name)
        variable = CellVar(site, d.var.kinds)
        return extended(frame, axis, d, variable, iota(axis), axis.size).when(ok)
    if d.place is not None:
        raise NotSupported("a list of cells in braces", d.origin, "write the sentence for each of the cells by itself")
    axis = w.axis(d.var.name, size)
    variable = CellVar(iota(axis), d.var.kinds, axis)
    return extended(frame, axis, d, variable, variable.site, size)


def sites_in(place: ir.Near, kinds: tuple[str, ...], frame: Frame, w: Writer, name: str) -> tuple[Value, Axis, Value]:
    """Returns the numbers (among `kinds`) of a shape's cells around an anchor, their axis, and which are there."""
    layout = w.module.layout
    size = layout.num_cells(kinds)
    anchor = frame.variables[place.anchor.name]
    shape = w.module.shape(place.shape)
    label = f"{place.shape.split('(')[0]}_{'_'.join(kinds)}"
    if isinstance(anchor, CellVar):
        state_reads.check_placed(anchor)
        table = layout.neighbours_table(anchor.kinds, shape, kinds)
        axis = w.axis(name, table.value.shape[1])
        constant = w.module.constant(label, table, f"cells of {', '.join(kinds)} in {shape.name} of each cell; past the end: none")
        if anchor.axis is not None:
            site = Value(constant, "i32", (anchor.axis, axis))
        else:
            site = Value(f"{constant}[{anchor.site.text}]", "i32", (*anchor.site.axes, axis))
        return site, axis, binary("<", site, literal(size, "i32"), "bool")
    swept = sweep(place, frame, w)
    table = w.module.constant(
        "site_of_" + "_".join(kinds),
        layout.site_table(kinds),
        f"number of each cell among {', '.join(kinds)}; past the end: none",
    )
    site = w.keep(label, Value(f"{table}[{wrapped(swept.cells)}]", "i32", swept.cells.axes))
    there = both(binary("<", site, literal(size, "i32"), "bool"), swept.ok if _has_inner_blocks(shape, w) else None)
    assert there is not None
    return site, swept.axis, there


def _has_inner_blocks(shape: ir.Shape, w: Writer) -> bool:
    """Whether some cell of the map ends a lane of the shape; off the map there is nothing to be shielded."""
    if shape.see_through or not any(len(lane) > 1 for lane in shape.lanes):
        return False
    conditional = any(b.what == shape.name and b.condition is not None for k in w.module.game.kinds for b in k.blocks)
    return conditional or bool(w.module.layout.blocking_table(shape.name).value.any())


def sweep(place: ir.Near, frame: Frame, w: Writer) -> Swept:
    """Returns the cells of a shape around an agent or a cell."""
    anchor = frame.variables[place.anchor.name]
    shape = w.module.shape(place.shape)
    layout = w.module.layout
    offsets = layout.offsets_table(shape)
    ident = "".join(c if c.isalnum() else "_" for c in place.shape).strip("_")
    name = w.module.constant(f"{ident}_offsets", offsets, f"cells of {shape.name} from an agent's cell, for each heading")
    axis = _shape_axis(w, ident, offsets.value.shape[1], anchor)
    if isinstance(anchor, AgentVar):
        at, facing = state_reads.position(anchor, w), state_reads.heading(anchor)
    else:  # a cell has no heading, and the shapes around cells have no direction
        at, facing = state_reads.cell(anchor, w), literal(0, "i32")
    index = "0" if shape.see_through else facing.text
    step = f"{name}[{index}]"
    lead = f"{wrapped(at)}[{', '.join([':'] * len(at.axes) + ['None'])}]" if at.axes else at.text
    if shape.see_through and at.axes:
        step = f"{step}[{', '.join(['None'] * len(at.axes))}, :]"
    cells = w.keep(f"{ident}_cells", Value(f"{lead} + {step}", "i32", (*at.axes, axis)))
    ok = _reached(shape, ident, at, facing, cells, axis, w)
    if axis in frame.axes:  # the same shape of the same agent once more inside itself
        other = w.axis(ident, axis.size)
        cells, ok = (replace(v, axes=tuple(other if a == axis else a for a in v.axes)) for v in (cells, ok))
        axis = other
    return Swept(cells, axis, ok)


def _shape_axis(w: Writer, ident: str, size: int, anchor: AgentVar | CellVar) -> Axis:
    """One axis a shape and anchor, so that cells found twice are the same array."""
    key = (f"axis of {ident}", repr(anchor))
    if key not in w.known:
        made = w.axis(ident, size)
        w.known[key] = made  # type: ignore[assignment]
    return w.known[key]  # type: ignore[return-value]


def _reached(shape: ir.Shape, ident: str, at: Value, facing: Value, cells: Value, axis: Axis, w: Writer) -> Value:
    """Returns which of the cells are on the map and not behind a cell that blocks the shape."""
    layout = w.module.layout
    inside = w.module.constant("inside", layout.inside_table, "cells of the map in the frame")
    on_map = Value(f"{inside}[{cells.text}]", "bool", cells.axes)
    if not _has_inner_blocks(shape, w):
        return on_map
    if any(b.what == shape.name and b.condition is not None for k in w.module.game.kinds for b in k.blocks):
        return w.keep(f"{ident}_reached", _walked(shape, on_map, cells, axis, w))
    if axis.size > 32:
        what = f"a shape of {axis.size} cells that something on the map blocks (at most 32)"
        raise NotSupported(what, shape.origin, "make it smaller, or let nothing block it")
    text = "u8" if axis.size <= 8 else "u32"
    table = w.module.constant(
        f"{ident}_reach",
        layout.reach_table(shape),
        f"cells of {shape.name} not behind what blocks it: bits by cell and heading",
    )
    bits = Value(f"{table}[{wrapped(at)} * 4 + {facing.text}]", text, at.axes)
    shifted = binary(">>", bits, iota(axis, text), text)
    return w.keep(f"{ident}_reached", binary("!=", binary("&", shifted, literal(1, text), text), literal(0, text), "bool"))


def _walked(shape: ir.Shape, on_map: Value, cells: Value, axis: Axis, w: Writer) -> Value:
    """Lanes that may end at cells whose state decides: walked cell by cell."""
    layout = w.module.layout
    fixed = w.module.constant(f"blocks_{shape.name}", layout.blocking_table(shape.name), f"cells that always block {shape.name}")
    blocked = Value(f"{fixed}[{cells.text}]", "bool", cells.axes)
    for kind in w.module.game.kinds:
        for block in kind.blocks:
            if block.what == shape.name and block.condition is not None and layout.num_cells((kind.name,)):
                here = blocked_by(block, kind, cells, w)
                blocked = binary("|", blocked, here, "bool")
    blocked = w.keep(f"{shape.name}_blocked", blocked)
    starts = np.zeros(axis.size, bool)
    starts[np.cumsum([0, *(len(lane) for lane in shape.lanes)])[:-1]] = True
    first = w.module.constant(f"{shape.name}_starts", starts, f"first cells of the lanes of {shape.name}")
    return Value(f"reached({blocked.text}, {on_map.text}, {first})", "bool", cells.axes)


def blocked_by(block: ir.Block, kind: ir.Kind, cells: Value, w: Writer, agent: AgentVar | None = None) -> Value:
    """Returns which of the cells are of a kind and block, by the state of the snapshot."""
    layout = w.module.layout
    size = layout.num_cells((kind.name,))
    table = w.module.constant(
        f"site_of_{kind.name}",
        layout.site_table((kind.name,)),
        f"number of each cell among {kind.name}; past the end: none",
    )
    site = Value(f"{table}[{wrapped(cells)}]", "i32", cells.axes)
    if agent is None and any(isinstance(n, ir.Member) and n.who == "agent" for n in ir.walk(block)):
        what = "a shape blocked by a condition on the agent"
        raise NotSupported(what, block.origin, "`blocks agents` may ask about the agent; what blocks a shape asks about the cell alone")
    variables: dict[str, AgentVar | CellVar] = {kind.name: CellVar(site, (kind.name,))}
    if agent is not None:
        variables["agent"] = agent
    assert block.condition is not None
    test = lower(block.condition, Frame(axes=cells.axes, variables=variables), w)
    both_ = both(binary("<", site, literal(size, "i32"), "bool"), test)
    assert both_ is not None
    return both_


def agents_in(place: ir.Near, variable: AgentVar, frame: Frame, w: Writer) -> Value:
    """Returns which agents stand on a cell of the shape."""
    anchor = frame.variables[place.anchor.name]
    shape = w.module.shape(place.shape)
    assert variable.axis is not None
    mine = state_reads.position(variable, w)
    if isinstance(anchor, CellVar):
        offsets = w.module.constant(f"{shape.name.split('(')[0]}_around", w.module.layout.offsets(shape)[0], f"cells of {shape.name}")
        at = state_reads.cell(anchor, w)
        axis = w.axis("around", len(w.module.layout.shape_cells(shape)))
        lead = f"{wrapped(at)}[{', '.join([':'] * len(at.axes) + ['None'])}]" if at.axes else at.text
        tail = f"{offsets}[{', '.join(['None'] * len(at.axes))}, :]" if at.axes else offsets
        cells, ok = Value(f"{lead} + {tail}", "i32", (*at.axes, axis)), None
    else:
        swept = sweep(place, frame, w)
        cells, axis = swept.cells, swept.axis
        ok = swept.ok if _has_inner_blocks(shape, w) else None
    axes = (*cells.axes[:-1], variable.axis) if variable.axis not in cells.axes else cells.axes[:-1]
    here = f"{wrapped(cells)}[{', '.join([':'] * len(cells.axes) + ['None'])}] == "
    here += f"{mine.text}[{', '.join(['None'] * len(cells.axes))}, :]"
    if ok is not None:
        here = f"({here}) & {wrapped(ok)}[{', '.join([':'] * len(ok.axes) + ['None'])}]"
    return w.keep(
        "in_" + "".join(c if c.isalnum() else "_" for c in place.shape).strip("_"),
        Value(f"jnp.any({here}, axis={len(cells.axes) - 1})", "bool", axes),
    )

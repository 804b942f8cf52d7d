"""Lowers reads of the state: fields, positions, attributes, and cells as values of fields."""

from collections.abc import Iterable
from dataclasses import replace

from sjdsl.compiler import ir
from sjdsl.compiler.ir.entity_types import AGENTS
from sjdsl.compiler.ir.names import attribute_name, attribute_of
from sjdsl.compiler.ir.queries import body_types, sets
from sjdsl.compiler.lower.axes import TRUE, Axis, Value, as_dtype, looked_up, select, size_of
from sjdsl.compiler.lower.scope import AgentVar, CellVar, IterationScope, Variable
from sjdsl.compiler.lower.writer import Writer
from sjdsl.compiler.program.expressions import (
    NEW_AXIS,
    DType,
    Expression,
    Name,
    call,
    concatenated,
    path,
    reduction,
)

POSITION = path("state.position")
HEADING = path("state.heading")
ROW = 8  # bits of the column in a stored cell: a map has at most 256 columns
NO_CELL = -1
MANY = 64  # computed cells from which on what is looked up is worth computing in memory first


def field(e: ir.FieldRead, owner: Variable | None, w: Writer) -> Value:
    """Returns the value of a field; enum values as uint8 numbers, integers as int32.

    `water.state` is `state.water_state` if the variable `water` is each cell once, in order, and
    `state.water_state[water]` if it is computed numbers.

    owner: whose field it is, None for a field of the world.
    """
    if isinstance(owner, CellVar) and owner.painted is not None:
        value = dict(owner.painted).get(e.name)
        if value is None:
            owner = placed(owner, w)
        elif e.type.kind == "agent":  # painted as its number plus 1, so that 0 is nobody
            return as_dtype(replace(value, dtype="u8"), "i32") - 1
        else:
            return _widened(value, e.type)
    if isinstance(owner, CellVar) and len(owner.kinds) > 1:
        return _group_field(e, owner, w)
    declared = w.module.field(e)
    row_dims = w.module.row_dims(e.type)
    stored = Value(w.stored(attribute_name(declared)), storage(declared, w), (), row_dims)
    if declared.type.kind == "word":
        stored = as_dtype(stored, "u8")
    if isinstance(owner, CellVar) and owner.beside:
        stored = replace(stored, node=w.beside(stored.node), axes=owner.number.axes)
    elif owner is not None:
        stored = _looked_up(owner, stored, w)
    return _widened(stored, declared.type)


def _looked_up(owner: Variable, stored: Value, w: Writer) -> Value:
    """Returns what `_entries_of` does; for many computed cells, `stored` goes into memory first."""
    if isinstance(owner, CellVar) and owner.axis is None:
        many = max(MANY, w.layout.num_cells(owner.kinds))
        if size_of(owner.number.axes) >= many:
            node = call("looked_up", stored.node, owner.number.node)
            return replace(stored, node=node, axes=owner.number.axes)
    return _entries_of(owner, stored)


def _entries_of(owner: Variable, stored: Value) -> Value:
    """Returns the entries for the agents or cells that a variable is.

    stored: an entry for each agent or cell, in order, with no named axis yet.
    """
    if owner.axis is not None:
        return replace(stored, axes=(owner.axis,))
    return replace(stored, node=stored.node[owner.number.node], axes=owner.number.axes)


def _group_field(e: ir.FieldRead, owner: CellVar, w: Writer) -> Value:
    """Returns a field of cells that may be of several kinds, which all have it.

    Each kind has a vector over its own cells. They are put after one another, then into the order
    of the cells on the map.
    """
    group = "_".join(owner.kinds)
    fields = [w.module.field(e, kind) for kind in owner.kinds]
    vectors = [w.stored(attribute_name(field)) for field in fields]
    table = w.layout.order_table(owner.kinds)
    order = w.module.constant(f"order_{group}", table, "cells of a group in reading order")
    in_order = Value(concatenated(vectors)[order], storage(fields[0], w))
    whole = w.keep(f"{group}_{e.name}", in_order)
    whole = replace(whole, row_dims=w.module.row_dims(e.type))
    return _widened(_looked_up(owner, whole, w), fields[0].type)


def _widened(value: Value, type_: ir.Type) -> Value:
    """Returns a field's value as expressions compute with it: integers as int32, not bytes."""
    return as_dtype(value, "i32") if type_.kind == "int" else value


def storage(declared: ir.VarField, w: Writer) -> DType:
    """Returns the dtype of a field: a byte for words and small ranges, bits for sets of agents.

    One number of the world is never a byte: that would save three bytes an environment, and XLA
    for processors with AVX-512 may end the process when a byte of each environment is compared
    together with bytes of its agents (openxla/xla#44943).
    """
    match declared.type.kind:
        case "real":
            return "f32"
        case "agents":
            return w.module.set_dtype
        case "word" | "int" as kind if declared.held_by.what != "world" or declared.type.indexed_by:
            return "u8" if kind == "word" or fits_byte(declared, w) else "i32"
        case _:
            return "i32"


def fits_byte(declared: ir.VarField, w: Writer) -> bool:
    """Returns whether all values of a field of integers are those of a byte."""
    high = timer_bound(declared, w.module.nodes) if declared.timer else declared.type.high
    return declared.type.low >= 0 and high <= 255


def timer_bound(declared: ir.VarField, nodes: Iterable[ir.Node]) -> float:
    """Returns the largest value a timer begins with or is set to. nodes: all of the game."""
    bounds = [0.0]
    for node in nodes:
        match node:
            case ir.GlyphMeaning() if declared.held_by == ir.EntityType("cell", (node.kind,)):
                for name, value in node.starts:
                    if name == declared.name and isinstance(value, int):
                        bounds.append(value)
            case ir.Set() if sets(node, declared):
                bounds.append(node.value.type.high)
    return max(bounds)


def position(owner: AgentVar, w: Writer) -> Value:
    """Returns the cells in the frame on which agents or movers are."""
    cells = _entries_of(owner, Value(positions(w, owner.entity_type), "i32"))
    return cells if owner.axis is not None else w.keep("position", cells)


def location(variable: Variable, w: Writer) -> Value:
    """Returns the cells in the frame of agents, movers or cell variables."""
    return position(variable, w) if isinstance(variable, AgentVar) else cell(variable, w)


def heading(owner: AgentVar, w: Writer) -> Value:
    """Returns the headings of agents or movers, int32."""
    stored = w.stored(attribute_of("heading", owner.entity_type))
    if owner.entity_type.what == "mover":  # a field of words, and so a byte
        return as_dtype(_entries_of(owner, Value(stored, "u8")), "i32")
    return _entries_of(owner, Value(stored, "i32"))


def moved(owner: AgentVar, w: Writer) -> Value:
    """Returns whether the last movement changed the cells of agents."""
    return _entries_of(owner, Value(w.stored(attribute_of("moved", owner.entity_type)), "bool"))


def present(owner: AgentVar, w: Writer) -> Value:
    """Returns who is on the map."""
    if w.starting or not w.module.can_be_away(owner.entity_type):
        return TRUE
    is_somewhere = position(owner, w).ne(nowhere(w))
    return w.keep("present", is_somewhere)


def nowhere(w: Writer) -> Value:
    """Returns the cell of agents that are not on the map."""
    return Value(w.module.number("nowhere", 0, "the cell of agents that are not on the map"), "i32")


def positions(w: Writer, entity_type: ir.EntityType = AGENTS) -> Expression:
    """Returns the cells in the frame of all agents, or of all movers of a name: `[N]`."""
    return w.stored(attribute_of("position", entity_type))


def everybody(w: Writer, entity_type: ir.EntityType) -> AgentVar:
    """Returns all agents or movers, for expressions that don't read their numbers."""
    extent = w.module.extent(entity_type)
    unread = Value(Name(entity_type.plural), "i32")
    axis = Axis("", extent.size, 0, extent.name)
    return AgentVar(unread, axis, entity_type)


def all_positions(w: Writer, but: ir.EntityType | None = None) -> Expression:
    """Returns the cells in the frame of all agents and movers, without those of the type `but`."""
    entity_types = [entity_type for entity_type in body_types(w.game) if entity_type != but]
    parts = [positions(w, entity_type) for entity_type in entity_types]
    name = "bodies" if but is None else "others"
    return w.keep_node(name, concatenated(parts), "i32")


def cell(owner: CellVar, w: Writer) -> Value:
    """Returns the cells in the frame that a variable is."""
    if owner.painted is not None:
        return _seen_cell(owner, w)
    return _entries_of(owner, Value(cells_of(owner.kinds, w), "i32"))


def _seen_cell(owner: CellVar, w: Writer) -> Value:
    """Returns where each cell of each window is, in the frame.

    For an observer that is away the cells mean nothing.
    """
    observer, cells = owner.seen
    comment = "cells of a window from the observer's cell, for each heading"
    table = w.module.constant("view_offsets", w.layout.view_table, comment)
    steps = Value(table[HEADING], "i32", (observer, cells))
    observers = Value(POSITION, "i32", (observer,))
    return w.keep("seen_cells", on_map(observers + steps, w))


def seen_steps(w: Writer, observer: Axis, cells: Axis) -> Value:
    """Returns how many steps each cell of a window is from the observer."""
    comment = "steps from the observer to each cell of its window"
    table = w.module.constant("view_steps", w.layout.steps_table, comment)
    if w.layout.wraps:  # round a map that is not square the way depends on the heading
        return Value(table[HEADING], "i32", (observer, cells))
    return Value(table, "i32", (cells,))


def on_map(cells: Value, w: Writer) -> Value:
    """Returns cells of the frame as cells of the map.

    If the map wraps, those beyond an edge are cells at the other side.
    """
    if not w.layout.wraps:
        return cells
    comment = "the cell of the map that a cell of the frame is; 1: none"
    table = w.module.constant("around", w.layout.edges_table, comment)
    return looked_up(table, cells, "i32")


def cells_of(kinds: tuple[str, ...], w: Writer) -> Name:
    """Returns the table of the cells of some kinds."""
    table = w.layout.cells_table(kinds)
    return w.module.constant(f"cells_{'_'.join(kinds)}", table, f"cells of {', '.join(kinds)}")


def placed(owner: CellVar, w: Writer) -> CellVar:
    """Returns a variable as numbers among the cells of its kinds.

    Only a cell of a window is not so yet: it is known by its place in the window. Where a window
    shows another kind, the number means nothing.
    """
    if owner.painted is None:
        return owner
    site = site_at(_seen_cell(owner, w), owner.kinds, w)
    return CellVar(w.keep(f"seen_{'_'.join(owner.kinds)}", site), owner.kinds)


def site_at(cells: Value, kinds: tuple[str, ...], w: Writer) -> Value:
    """Returns the numbers of cells of the frame among those of `kinds`, past the end if none."""
    comment = f"number of each cell among {', '.join(kinds)}; past the end: none"
    numbers = w.layout.site_table(kinds)
    table = w.module.constant(f"site_of_{'_'.join(kinds)}", numbers, comment)
    return looked_up(table, cells, "i32")


def is_site(site: Value, kinds: tuple[str, ...], w: Writer) -> Value:
    """Returns whether numbers are those of cells of `kinds`, and not past the end."""
    return site < w.module.num_cells(kinds)


def site_under(owner: AgentVar, kinds: tuple[str, ...], w: Writer) -> tuple[Value, Value]:
    """Returns the number of the cell of `kinds` under each agent, and whether there is one."""
    under = site_at(position(owner, w), kinds, w)
    site = w.keep(f"{'_'.join(kinds)}_under", under)
    return site, is_site(site, kinds, w)


def occupied(owner: CellVar, w: Writer) -> Value:
    """Returns which of the cells that a variable is have an agent or a mover on them."""
    bodies = all_positions(w)
    if owner.axis is not None:
        any_axis = Axis("", 1, 0)  # of the bodies; nothing is aligned with it
        under = site_at(Value(bodies, "i32", (any_axis,)), owner.kinds, w)
        site = w.keep(f"{'_'.join(owner.kinds)}_under", under)
        covered = call("occupied", site.node, w.module.num_cells(owner.kinds))
        return replace(w.keep("covered", Value(covered, "bool")), axes=(owner.axis,))
    cells = cell(owner, w)
    if not cells.axes:
        return Value(reduction("any", cells.node.eq(bodies)), "bool")
    each_body = bodies[*[NEW_AXIS] * len(cells.axes), :]
    has_body = cells.node[..., None].eq(each_body)
    return Value(reduction("any", has_body, (-1,)), "bool", cells.axes)


def no_cell(w: Writer) -> Value:
    """Returns the number that stands for no cell."""
    comment = "in place of a cell: 256 * row + column"
    return Value(w.module.number("no_cell", NO_CELL, comment), "i32")


def kept_cell(e: ir.Expr, scope: IterationScope, w: Writer) -> Value:
    """Returns a cell as fields store it: 256 times its row on the map, plus its column."""
    if not isinstance(e, ir.Member):  # it has been stored in this form
        return w.value(e, scope)
    variable = scope.variables[e.name]
    assert isinstance(variable, CellVar)
    in_frame = cell(variable, w)
    row = in_frame // w.module.frame_cols - w.module.pad
    col = in_frame % w.module.frame_cols - w.module.pad
    return w.keep("place", (row << ROW) + col)


def frame_cell(value: Value, w: Writer) -> Value:
    """Returns the cell of the frame for a cell as fields store it; 0, nowhere, for no cell."""
    row = (value >> ROW) + w.module.pad
    col = (value & (2**ROW - 1)) + w.module.pad
    in_frame = row * w.module.frame_cols + col
    return w.keep("at", select(value >= 0, in_frame, nowhere(w)))


def held_cell(e: ir.Expr, kinds: tuple[str, ...], scope: IterationScope, w: Writer) -> CellVar:
    """Returns the cell that an expression is, by its number among `kinds`, past the end if none."""
    in_frame = frame_cell(w.value(e, scope), w)
    site = site_at(in_frame, kinds, w)
    return CellVar(w.keep(f"{'_'.join(kinds)}_held", site), kinds)

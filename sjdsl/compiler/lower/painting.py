"""Paints the map as observers see it: numbers in cells, packed into as few bytes as fit.

A painted plane has a byte for each cell of the frame. Its bits are divided into parts: what is in
the cell, which agent stands on it, which mover, and which marks it has.
"""

from sjdsl.compiler import ir
from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.ir.names import attribute_name
from sjdsl.compiler.ir.queries import body_types, movers_named
from sjdsl.compiler.lower import state_reads
from sjdsl.compiler.lower.axes import Value, aligned, as_dtype, literal, union
from sjdsl.compiler.lower.cell_appearance import Look, looks, seen_marks
from sjdsl.compiler.lower.writer import Writer
from sjdsl.compiler.program.expressions import Arange, Cast, Name, call, path, zeros


class Part(Record):
    """Some bits of a painted byte. plane: which of the painted planes. shift: its lowest bit."""

    name: str
    plane: int
    shift: int
    bits: int


def parts_of(game: ir.Game, by_id: bool) -> tuple[Part, ...]:
    """Returns the parts for content, agents, movers and marks, in as few planes as they fit.

    by_id: whether an agent is painted as its number, not only as its heading.
    """
    num_contents = max(look.raw + look.raw_values for look in looks(game))
    agent_bits = _bits(game.agents.number + 1) if by_id else 3
    wanted = [("content", _bits(num_contents)), ("agent", agent_bits)]
    for movers in game.movers:
        number = shown_movers(movers, game)
        if number:
            wanted.append((movers.name, _bits(1 + number)))
    if seen_marks(game):
        wanted.append(("marks", len(seen_marks(game))))
    parts: list[Part] = []
    used = [0]  # bits of each plane
    for name, bits in wanted:
        with_room = [plane for plane, taken in enumerate(used) if taken + bits <= 8]
        if with_room:
            plane = with_room[0]
        else:
            plane = len(used)
            used.append(0)
        parts.append(Part(name, plane, used[plane], bits))
        used[plane] += bits
    return tuple(parts)


def shown_movers(movers: ir.Movers, game: ir.Game) -> int:
    """Returns how many different numbers movers of a name are painted with.

    All have their own if something of theirs is seen; 1 if only where they are is; 0 if nothing is.
    """
    number = 0
    for observable in game.observables:
        if observable.what != "mover" or observable.kind != movers.name:
            continue
        number = 1
        conditions = (observable.hidden_when, observable.shown_when)
        if observable.field or any(map(_reads_mover, conditions)):
            return movers.number
    return number


def _bits(values: int) -> int:
    """Returns how many bits can hold so many different values."""
    return max(1, (values - 1).bit_length())


def _reads_mover(condition: ir.Expr | None) -> bool:
    if condition is None:
        return False
    members = [node for node in ir.walk(condition) if isinstance(node, ir.Member)]
    return any(member.entity_type.what == "mover" for member in members)


def shift_of(part: Part, w: Writer) -> Value:
    """Returns the place of a part's lowest bit, as a named constant of the module."""
    if not part.shift:
        return literal(0, "u8")
    return Value(w.module.number(f"{part.name}_shift", part.shift), "u8")


def paint_planes(parts: tuple[Part, ...], by_id: bool, w: Writer) -> list[Name]:
    """Writes the planes with all that is seen of the cells of the map; returns their names."""
    layout = w.layout
    by_name = {part.name: part for part in parts}
    content = by_name["content"]
    numbers = {look.kind.name: look.raw << content.shift for look in looks(w.game)}
    comment = "looks of the cells of the frame, fields aside"
    base = w.module.constant("base", layout.base_table(numbers), comment)
    frame_cells = w.module.number("frame_cells", layout.rows * layout.cols)
    empty = zeros("u8", frame_cells)
    planes = []
    for number in range(1 + max(part.plane for part in parts)):
        planes.append(w.bind(f"plane_{number}", base if number == content.plane else empty))
    _paint_fields(planes[content.plane], content, w)
    for number, phase in enumerate(seen_marks(w.game)):
        marks = by_name["marks"]
        plane = planes[marks.plane]
        w.origin = phase.origin
        bit = w.module.number(f"mark_{phase.name}_bit", 1 << marks.shift + number)
        w.set(plane, call("paint", plane, path(f"state.mark_{phase.name}"), bit))
    for entity_type in body_types(w.game):
        if entity_type.name in by_name:
            part = by_name[entity_type.name]
            _paint_bodies(planes[part.plane], part, entity_type, by_id, w)
    return planes


def first_look(look: Look, w: Writer) -> Value:
    """Returns the first number of a kind's looks as painted."""
    return Value(w.module.number(f"{look.kind.name}_look", look.raw, "as it is painted"), "u8")


def _paint_fields(plane: Name, content: Part, w: Writer) -> None:
    """Writes the looks of cells of which fields are seen."""
    for look in looks(w.game):
        kinds = (look.kind.name,)
        if not look.painted or not w.layout.num_cells(kinds):
            continue
        cells = state_reads.cells_of(kinds, w)
        w.origin = look.kind.origin
        values = []
        for field, _ in look.painted:
            value = Value(path(f"state.{attribute_name(field)}"), state_reads.storage(field, w))
            if field.type.kind == "agent":  # one up: 0 is nobody
                value = value + 1
            values.append(value)
        sizes = tuple(size for _, size in look.painted)
        number = look_number(first_look(look, w), sizes, values)
        shifted = number << shift_of(content, w)
        w.set(plane, call("fill", plane, cells, shifted.node))


def _paint_bodies(
    plane: Name, part: Part, entity_type: ir.EntityType, by_id: bool, w: Writer
) -> None:
    """Writes where agents or movers are: their number, their heading, or 1."""
    game = w.game
    is_agent = entity_type.what == "agent"
    extent = w.module.extent(entity_type)
    w.origin = game.agents.origin if is_agent else movers_named(game, entity_type.name).origin
    are_told_apart = by_id if is_agent else part.bits > 1
    if are_told_apart:
        shown = Value(Arange(extent, "u8"), "u8") + 1
    elif is_agent:
        shown = Value(Cast(state_reads.HEADING, "u8"), "u8") + 1
    else:
        shown = Value(call("jnp.ones", extent, path("jnp.uint8")), "u8")
    shifted = shown << shift_of(part, w)
    w.set(plane, call("paint", plane, state_reads.positions(w, entity_type), shifted.node))


def look_number(first: Value, sizes: tuple[int, ...], values: list[Value]) -> Value:
    """Returns the numbers of looks: `first`, plus the number of a combination of values.

    sizes: how many values each place can have; the first place is the most significant.
    """
    if len(values) == 1:
        return as_dtype(values[0], "u8") + first
    axes = union(*(value.axes for value in values))
    nodes = [aligned(value.array, axes) for value in values]
    return Value(call("look_number", first.node, sizes, *nodes), "u8", axes)

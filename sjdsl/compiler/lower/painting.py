"""Painting: lowers the map as an observer sees it to numbers in its cells, packed into as few bytes as possible."""

from sjdsl.compiler import ir
from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.ir.names import attribute_name
from sjdsl.compiler.ir.queries import body_sorts, movers_named
from sjdsl.compiler.lower import state_reads
from sjdsl.compiler.lower.axes import Value, aligned, as_dtype, binary, literal, union
from sjdsl.compiler.lower.cell_appearance import Look, looks, seen_marks
from sjdsl.compiler.lower.writer import Writer
from sjdsl.compiler.program.expressions import Arange, Cast, Name, call, constant, path, scalar

POSITION, HEADING = path("state.position"), path("state.heading")


class Part(Record):
    """Some bits of a painted byte. `marks`: the phase whose marks they are."""

    name: str
    plane: int
    shift: int
    bits: int
    marks: ir.Phase | None = None


def parts_of(game: ir.Game, by_id: bool) -> tuple[Part, ...]:
    """Returns where content, agents and marks are kept: packed into as few bytes as they fit."""
    contents = max(look.raw + look.raw_values for look in looks(game))
    wanted: list[tuple[str, int, ir.Phase | None]] = [("content", _bits(contents), None)]
    wanted.append(("agent", _bits(game.agents.number + 1) if by_id else 3, None))
    wanted += [
        (sort.name, _bits(1 + shown_movers(sort, game)), None)
        for sort in game.movers
        if shown_movers(sort, game)
    ]
    wanted += [(f"mark_{phase.name}", 1, phase) for phase in seen_marks(game)]
    found: list[Part] = []
    used = [0]
    for name, bits, phase in wanted:
        plane = next((i for i, u in enumerate(used) if u + bits <= 8), len(used))
        if plane == len(used):
            used.append(0)
        found.append(Part(name, plane, used[plane], bits, phase))
        used[plane] += bits
    return tuple(found)


def shown_movers(sort: ir.Movers, game: ir.Game) -> int:
    """Returns how many movers of a sort are told apart: 1 if only their presence is seen, 0 if nothing is."""
    shown = [s for s in game.observables if s.what == "mover" and s.kind == sort.name]
    conditions = [c for s in shown for c in (s.hidden_when, s.shown_when) if c is not None]
    asked = any(
        isinstance(n, ir.Member) and n.sort.what == "mover" for c in conditions for n in ir.walk(c)
    )
    return sort.number if asked or any(s.field for s in shown) else min(len(shown), 1)


def _bits(values: int) -> int:
    return max(1, (values - 1).bit_length())


def shift_of(part: Part, w: Writer) -> Value:
    """Returns the place of a part's lowest bit."""
    return (
        literal(0, "u8")
        if not part.shift
        else Value(w.module.number(f"{part.name}_shift", part.shift), "u8")
    )


def paint_planes(parts: tuple[Part, ...], by_id: bool, w: Writer) -> list[Name]:
    """Writes the planes of bytes in which everything that is seen is painted into the cells of the map."""
    layout, game = w.module.layout, w.module.game
    content = next(p for p in parts if p.name == "content")
    base = layout.base_table({look.kind.name: look.raw << content.shift for look in looks(game)})
    name = w.module.constant("base", base, "looks of the cells of the frame, fields aside")
    empty = call(
        "jnp.zeros", w.module.number("frame_cells", layout.rows * layout.cols), path("jnp.uint8")
    )
    planes = [
        w.bind(f"plane_{plane}", name if plane == content.plane else empty)
        for plane in range(1 + max(p.plane for p in parts))
    ]
    for look in looks(game):
        if not look.painted or not layout.num_cells((look.kind.name,)):
            continue
        cells = state_reads.cells_of((look.kind.name,), w)
        w.origin = look.kind.origin
        values = []
        for field, _ in look.painted:
            stored = Value(path(f"state.{attribute_name(field)}"), state_reads.storage(field, w))
            values.append(
                binary("+", stored, literal(1, "i32"), "i32")
                if field.type.kind == "agent"
                else stored
            )  # one up, 0 is nobody
        value = binary(
            "<<",
            look_number(first_look(look, w), tuple(size for _, size in look.painted), values),
            shift_of(content, w),
            "u8",
        )
        w.set(planes[content.plane], call("fill", planes[content.plane], cells, value.node))
    for part in parts:
        if part.marks is not None:
            w.origin = part.marks.origin
            bit = w.module.number(f"{part.name}_bit", 1 << part.shift)
            w.set(
                planes[part.plane],
                call("paint", planes[part.plane], path(f"state.{part.name}"), bit),
            )
    for sort in body_sorts(game):
        place = next((p for p in parts if p.name == sort.name), None)
        if place is None:  # nothing is seen of these movers
            continue
        is_agent, extent = sort.what == "agent", w.module.extent(sort)
        w.origin = game.agents.origin if is_agent else movers_named(game, sort.name).origin
        if by_id if is_agent else place.bits > 1:  # who it is, one up
            shown = binary("+", Value(Arange(extent, "u8"), "u8"), literal(1, "u8"), "u8")
        elif is_agent:
            shown = binary("+", Value(Cast(HEADING, "u8"), "u8"), literal(1, "u8"), "u8")
        else:
            shown = Value(call("jnp.ones", extent, path("jnp.uint8")), "u8")
        shifted = binary("<<", shown, shift_of(place, w), "u8")
        w.set(
            planes[place.plane],
            call("paint", planes[place.plane], state_reads.positions(w, sort), shifted.node),
        )
    return planes


def first_look(look: Look, w: Writer) -> Value:
    """Returns the first number of a kind's looks as painted."""
    return Value(w.module.number(f"{look.kind.name}_look", look.raw, "as it is painted"), "u8")


def look_number(first: Value, sizes: tuple[int, ...], values: list[Value]) -> Value:
    """Returns the numbers of looks: `first`, and how far each value is, of as many as `sizes` has for it, the first most significant."""
    if len(values) == 1:
        return binary("+", as_dtype(values[0], "u8"), first, "u8")
    axes = union(*(value.axes for value in values))
    nodes = [
        scalar(value.node, "u8") if value.literal else aligned(value, axes) for value in values
    ]
    return Value(call("look_number", first.node, constant(sizes), *nodes), "u8", axes)

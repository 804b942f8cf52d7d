"""Lowers what is seen of a cell besides its look: the values of its fields as painted, and its marks."""

from dataclasses import replace

from sjdsl.compiler.lower.axes import Axis, Value, binary, iota, literal, select
from sjdsl.compiler.lower.cell_appearance import (
    Look,
    looks,
)
from sjdsl.compiler.lower.painting import Part, first_look
from sjdsl.compiler.lower.scope import AgentVar, CellVar, IterationScope
from sjdsl.compiler.lower.writer import Writer
from sjdsl.compiler.program import expressions as array


def marks_seen(marks: list[Part], planes: dict[str, Value], seen: list[array.Name], w: Writer) -> Value:
    """Returns the marks of a cell as bits, one a phase."""
    first = planes[marks[0].name]
    if len(marks) == 1:
        return first
    if all(m.plane == marks[0].plane and m.shift == marks[0].shift + i for i, m in enumerate(marks)):
        shifted = binary(">>", replace(first, node=seen[marks[0].plane]), Value(w.module.number("mark_shift", marks[0].shift), "u8"), "u8")
        return binary("&", shifted, Value(w.module.number("mark_mask", 2 ** len(marks) - 1), "u8"), "u8")
    result = first
    for place, m in enumerate(marks[1:], 1):
        result = binary("|", result, binary("<<", planes[m.name], literal(place, "u8"), "u8"), "u8")
    return result


def somebody_seen(planes: dict[str, Value], w: Writer) -> Value:
    """Returns where an agent stands, the observer too."""
    return w.keep("somebody", binary("!=", planes["agent"], literal(0, "u8"), "bool"))


def without_hidden_marks(marks: Value, planes: dict[str, Value], axes: tuple[Axis, ...], w: Writer) -> Value:
    """Returns the marks that are seen: none on the cells on which they are hidden."""
    found = {look.kind.name: look for look in looks(w.module.game) if look.present}
    raw = w.keep("raw", planes["content"]) if any(h.on == "cells" for h in w.module.game.hidden) else planes["content"]
    for hidden in w.module.game.hidden:
        if hidden.what == "marks" and hidden.on == "agents":
            marks = select(somebody_seen(planes, w), literal(0, "u8"), marks)
        for look in (found[kind] for kind in hidden.kinds if kind in found):
            w.origin = hidden.origin
            there, values = look_fields(look, raw, w)
            if hidden.when is not None:
                place = seen_cell(look, hidden.name, values, axes)
                there = binary("&", there, w.value(hidden.when, place), "bool")
            marks = w.keep("marks", select(there, literal(0, "u8"), marks))
    return marks


def look_fields(look: Look, raw: Value, w: Writer) -> tuple[Value, dict[str, Value]]:
    """Returns which numbers of looks are of a kind, and the values of its painted fields, which mean nothing where another kind is."""
    name, first = look.kind.name, first_look(look, w)
    if not look.painted:
        return w.keep(f"is_{name}", binary("==", raw, first, "bool")), {}
    fields, sizes = zip(*((field.name, size) for field, size in look.painted), strict=True)
    call = array.call("look_fields", raw.node, first.node, array.constant(sizes))
    there, *values = w.keep_parts((f"is_{name}", *(f"{name}_{field}" for field in fields)), call)
    return replace(raw, node=there, dtype="bool"), {field: replace(raw, node=value) for field, value in zip(fields, values, strict=True)}


def seen_cell(look: Look, name: str, values: dict[str, Value], axes: tuple[Axis, ...]) -> IterationScope:
    """Returns the scope of a condition about the observer and the cell that it sees: what was painted of it need not be looked up."""
    cell = CellVar(literal(0, "i32"), (look.kind.name,), None, tuple(values.items()), axes)
    return IterationScope(axes=axes, variables={"agent": AgentVar(iota(axes[0]), axes[0]), name: cell})

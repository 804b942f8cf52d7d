"""Lowers what is seen of a cell besides its look: the values of its fields as painted, and its marks."""

from dataclasses import replace

from sjdsl.compiler.lower.axes import Axis, Value, binary, both, iota, literal, select
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
            there = w.keep(f"on_{look.kind.name}", inside_kind(look, raw, w))
            if hidden.when is not None:
                place = seen_cell(look, hidden.name, painted_values(look, raw, w), axes)
                there = binary("&", there, w.value(hidden.when, place), "bool")
            marks = w.keep("marks", select(there, literal(0, "u8"), marks))
    return marks


def inside_kind(look: Look, raw: Value, w: Writer) -> Value:
    """Returns whether a number of looks is of a kind."""
    if look.raw_values == 1:
        return binary("==", raw, first_look(look, w), "bool")
    below = binary("<", raw, literal(look.raw + look.raw_values, "u8"), "bool")
    inside = both(binary(">=", raw, first_look(look, w), "bool"), below)
    assert inside is not None
    return inside


def painted_values(look: Look, raw: Value, w: Writer) -> dict[str, Value]:
    """Returns the painted fields of a kind, taken out of the numbers of looks; where another kind is they mean nothing."""
    values: dict[str, Value] = {}
    rest = binary("-", raw, first_look(look, w), "u8")
    for field, size in reversed(look.painted):
        is_first = field is look.painted[0][0]
        value = rest if is_first else binary("%", rest, literal(size, "u8"), "u8")
        values[field.name] = w.keep(f"{look.kind.name}_{field.name}", value)
        rest = replace(rest, node=array.Binary("//", rest.node, array.Literal(size)))
    return values


def seen_cell(look: Look, name: str, values: dict[str, Value], axes: tuple[Axis, ...]) -> IterationScope:
    """Returns the scope of a condition about the observer and the cell that it sees: what was painted of it need not be looked up."""
    cell = CellVar(literal(0, "i32"), (look.kind.name,), None, tuple(values.items()), axes)
    return IterationScope(axes=axes, variables={"agent": AgentVar(iota(axes[0]), axes[0]), name: cell})

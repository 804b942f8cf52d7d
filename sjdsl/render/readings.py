"""Texts beside the board: what agents observe of the world and of themselves and no cell shows."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from sjdsl.compiler import ir
from sjdsl.compiler.ir.names import attribute_name
from sjdsl.compiler.ir.types import element
from sjdsl.interpreter.stored import loaded
from sjdsl.render.moment import Snapshot, shown_defines


@dataclass(frozen=True)
class Reading:
    """A value of the world, or one that each agent has.

    name: as the rules call it; attribute: its array in the state, "" for a define.
    """

    name: str
    attribute: str
    type: ir.Type

    def text(self, snapshot: Snapshot, agent: int | None = None) -> str:
        """Returns the value at one moment. `agent`: whose it is, None for one of the world."""
        if not self.attribute:
            return snapshot.defines.get(self.name, "")
        values = snapshot.values[self.attribute]
        value = values if agent is None else values[agent]
        return _value_text(loaded(value, self.type), self.type)


def world_readings(game: ir.Game) -> tuple[Reading, ...]:
    """Returns the fields of the world and the defines that agents observe, except `step`."""
    seen = {o.field for o in game.observables if o.what == "world"}
    fields = tuple(_reading(field) for field in game.fields if field.name in seen)
    return (*fields, *(Reading(o.field, "", o.type) for o in shown_defines(game)))


def agent_readings(game: ir.Game) -> tuple[Reading, ...]:
    """Returns the fields of agents that some agent observes."""
    seen = {o.field for o in game.observables if o.what in ("own", "other", "everyone")}
    return tuple(_reading(field) for field in game.agents.fields if field.name in seen)


def join_readings(readings: Sequence[Reading], snapshot: Snapshot, agent: int | None = None) -> str:
    """Returns values with their names, on one line."""
    return ", ".join(f"{reading.name} {reading.text(snapshot, agent)}" for reading in readings)


def _reading(field: ir.VarField) -> Reading:
    return Reading(field.name, attribute_name(field), field.type)


def _value_text(value: Any, type_: ir.Type) -> str:
    """Returns the text of a value in the interpreter's form; of an indexed field, each entry."""
    if type_.indexed_by:
        index = type_.indexed_by[0]
        entries = [_value_text(entry, element(type_)) for entry in value]
        if index.kind == "word":
            entries = [f"{name} {entry}" for name, entry in zip(index.names, entries, strict=True)]
        return " ".join(entries)
    match type_.kind:
        case "agents":
            return "+".join(map(str, sorted(value))) or "nobody"
        case "cell":
            return "nowhere" if value is None else str(tuple(value))
        case "real":
            return f"{value:.4g}"
        case _:
            return "nobody" if value is None else str(value)

"""Metadata of a generated module that its environment needs: events, variables, roles."""

from math import isfinite

from sjdsl.compiler import ir
from sjdsl.compiler.ir.names import attribute_name, param_attribute
from sjdsl.runtime.fields import StateField

ROLE = "role"  # a field of the agents by this name says who plays what


def events(game: ir.Game) -> tuple[tuple[str, str, int | None], ...]:
    """Returns each count of a step: its name, the attribute of the outcome, and which entry of its last axis."""
    counts: list[tuple[str, str, int | None]] = []
    for event in game.events:
        attribute = f"event_{param_attribute(event.name)}"
        counts += [(f"{event.name}[{word}]", attribute, i) for i, word in enumerate(event.by)] or [(event.name, attribute, None)]
    return tuple(counts)


def state_fields(game: ir.Game) -> tuple[StateField, ...]:
    """Returns every declared variable: those of cells, of agents and of the world."""
    fields = (*(field for kind in game.kinds for field in kind.fields), *game.agents.fields, *game.fields)
    return tuple(_state_field(attribute_name(field), field.type) for field in fields)


def _state_field(attribute: str, type_: ir.Type) -> StateField:
    match type_.kind:
        case "word":
            return StateField(attribute, "word", size=len(type_.words))
        case "agent" | "agents" | "condition":
            return StateField(attribute, type_.kind)
    limited = isfinite(type_.low) and isfinite(type_.high) and type_.low < type_.high
    return StateField(attribute, "number", low=type_.low, high=type_.high) if limited else StateField(attribute, "number")


def role_attribute(game: ir.Game) -> str | None:
    """Returns the attribute of State that holds the agents' roles; None if they have none, or a phase of the schedule writes it."""
    field = next((f for f in game.agents.fields if f.name == ROLE and f.type.kind == "word" and not f.type.by), None)
    if field is None or any(_writes_role(turn) for turn in game.schedule):
        return None
    return attribute_name(field)


def _writes_role(turn: ir.Node) -> bool:
    """Whether a phase sets the field `role` of an agent."""
    return any(isinstance(node, ir.Set) and any(_is_role(part) for part in ir.walk(node.target)) for node in ir.walk(turn))


def _is_role(node: ir.Node) -> bool:
    return isinstance(node, ir.FieldRead) and node.name == ROLE and node.place == "agent"

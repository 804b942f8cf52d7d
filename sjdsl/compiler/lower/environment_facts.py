"""Metadata of a generated module that its environment needs: events, variables, roles."""

from math import isfinite

from sjdsl.compiler import ir
from sjdsl.compiler.ir.names import attribute_name, attribute_of, param_attribute
from sjdsl.compiler.ir.queries import all_fields, counts_of, written_field
from sjdsl.runtime.fields import StateField

ROLE = "role"  # a field of the agents by this name says who plays what


def events(game: ir.Game) -> tuple[tuple[str, str, int | None], ...]:
    """Returns each count of a step: its name, the attribute of the outcome, and which entry of its last axis."""
    return tuple(
        (name, f"event_{param_attribute(event.name)}", None if word is None else i)
        for event in game.events
        for i, (word, name) in enumerate(counts_of(event))
    )


def state_fields(game: ir.Game) -> tuple[StateField, ...]:
    """Returns every declared variable: those of cells, of agents, of movers, each sort after where its members are, and of the world."""
    found: list[StateField] = []
    for field in all_fields(game):
        if (field.held_by.what, field.name) == ("mover", "heading"):
            found.append(StateField(attribute_of("position", field.held_by), "place"))
        found.append(_state_field(attribute_name(field), field.type))
    return tuple(found)


def _state_field(attribute: str, type_: ir.Type) -> StateField:
    match type_.kind:
        case "word":
            return StateField(attribute, "word", size=len(type_.words))
        case "agent" | "agents" | "cell" | "condition":
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
    """Whether a turn sets the field `role` of an agent."""
    written = (written_field(node.target) for node in ir.walk(turn) if isinstance(node, ir.Set))
    return any((field.held_by.what, field.name) == ("agent", ROLE) for field in written)

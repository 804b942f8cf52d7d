"""Values, members and changes in words."""

import numpy as np

from sjdsl.compiler import ir
from sjdsl.interpreter.account import Done
from sjdsl.interpreter.board import Board
from sjdsl.interpreter.state import HEADINGS, Away, Cell, Mover, Value
from sjdsl.trace.effects import Effect


def say_owner(owner: int | Mover | Cell | None, board: Board) -> str:
    """Returns `agent 2`, `deer 0`, `water (3, 4)`, or nothing for the world."""
    match owner:
        case None:
            return ""
        case Mover():
            return f"{owner.entity_type} {owner.number}"
        case Cell():
            return f"{board.kind_of[owner]} {say_cell(owner)}"
        case _:
            return f"agent {owner}"


def say_cell(cell: Cell) -> str:
    return f"({cell.row}, {cell.col})"


def say_value(value: Value, type_: ir.Type | None = None) -> str:
    """Returns a value of a field as its author would write it."""
    kind = type_.kind if type_ is not None else ""
    match value:
        case None:
            return "nowhere" if kind == "cell" else "nobody"
        case frozenset() if not value:
            return "nobody"
        case frozenset():
            return f"{{ {', '.join(f'agent {agent}' for agent in sorted(value))} }}"
        case Cell():
            return say_cell(value)
        case Mover():
            return f"{value.entity_type} {value.number}"
        case tuple() | np.ndarray():
            return "[" + ", ".join(say_value(entry, type_) for entry in value) + "]"
        case bool():
            return "yes" if value else "no"
        case int() if kind == "agent":
            return f"agent {value}"
        case str() | int():
            return str(value)
        case _:
            return f"{float(value):.7g}"


def say_effect(effect: Effect, board: Board) -> str:
    """Returns one change: `water (3, 4)  state: clean -> dirty`."""
    owner = say_owner(effect.owner, board)
    match effect.changed:
        case "field":
            old = say_value(effect.old, effect.type)
            change = f"{effect.name}: {old} -> {say_value(effect.new, effect.type)}"
        case "place":
            change = _say_journey(effect.old, effect.new)
        case "heading":
            change = f"faces: {HEADINGS[effect.old]} -> {HEADINGS[effect.new]}"
        case "away":
            change = _say_absence(effect.new)
        case "moved":
            change = f"moved: {say_value(effect.old)} -> {say_value(effect.new)}"
        case "reward":
            change = f"reward {float(effect.new):+.7g}"
        case "event":
            change = f"{effect.name} {effect.new:+d}"
        case "mark":
            change = "marks " + " ".join(say_cell(cell) for cell in effect.new)
        case "end":
            change = "the episode ends"
    return f"{owner}  {change}" if owner else change


def _say_journey(old: Cell | None, new: Cell | None) -> str:
    """Returns a change of place in words."""
    if new is None:
        return "stays off the map" if old is None else f"leaves {say_cell(old)}"
    if old is None:
        return f"comes to {say_cell(new)}"
    return f"goes from {say_cell(old)} to {say_cell(new)}"


def _say_absence(away: Away | None) -> str:
    """Returns a change of absence in words."""
    if away is None:
        return "is back on the map"
    if not away.ticks:
        return "is off the map for ever"
    return f"is off the map for {away.ticks} tick{'' if away.ticks == 1 else 's'}"


def say_names(
    done: Done, owner: int | Mover | Cell | None, turn_agents: frozenset[str], board: Board
) -> str:
    """Returns the values of the variables around a statement: `cleaner 0, level cut`.

    A variable that stands for the owner is left out.

    Args:
      turn_agents: the variables that stand for agents, not for numbers.
    """
    texts = []
    for name, value in done.names.items():
        is_body = name in turn_agents or isinstance(value, Cell | Mover)
        if is_body and value == owner:
            continue
        if isinstance(value, Mover) and name == value.entity_type:
            texts.append(f"{name} {value.number}")
        elif isinstance(value, Cell) and name == board.kind_of[value]:
            texts.append(say_owner(value, board))
        else:
            texts.append(f"{name} {say_value(value)}")
    return ", ".join(texts)

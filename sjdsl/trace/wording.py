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
            return f"{owner.sort} {owner.number}"
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
        case frozenset():
            return (
                "{ " + ", ".join(f"agent {agent}" for agent in sorted(value)) + " }"
                if value
                else "nobody"
            )
        case Cell():
            return say_cell(value)
        case Mover():
            return f"{value.sort} {value.number}"
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
    match effect.sort:
        case "field":
            change = f"{effect.name}: {say_value(effect.old, effect.type)} -> {say_value(effect.new, effect.type)}"
        case "place":
            change = _journey(effect.old, effect.new)
        case "heading":
            change = f"faces: {HEADINGS[effect.old]} -> {HEADINGS[effect.new]}"
        case "away":
            change = _absence(effect.new)
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


def _journey(old: Cell | None, new: Cell | None) -> str:
    if new is None:
        return f"leaves {say_cell(old)}" if old is not None else "stays off the map"
    return (
        f"comes to {say_cell(new)}"
        if old is None
        else f"goes from {say_cell(old)} to {say_cell(new)}"
    )


def _absence(away: Away | None) -> str:
    if away is None:
        return "is back on the map"
    return (
        f"is off the map for {away.ticks} tick{'' if away.ticks == 1 else 's'}"
        if away.ticks
        else "is off the map for ever"
    )


def say_names(
    done: Done, owner: int | Mover | Cell | None, turn_agents: frozenset[str], board: Board
) -> str:
    """Returns what the variables around a statement stand for: `cleaner 0, level cut`; not those that are the owner itself."""
    said = []
    for name, value in done.names.items():
        is_agent = name in turn_agents
        if isinstance(value, Mover):
            text = f"{name} {value.number}" if name == value.sort else f"{name} {say_value(value)}"
        elif isinstance(value, Cell):
            text = (
                say_owner(value, board)
                if name == board.kind_of[value]
                else f"{name} {say_cell(value)}"
            )
        else:
            text = f"{name} {say_value(value)}"
        if not ((is_agent or isinstance(value, Cell | Mover)) and value == owner):
            said.append(text)
    return ", ".join(said)

"""Values of the interpreter as the state of the compiled game stores them."""

from typing import Any

from sjdsl.compiler import ir
from sjdsl.interpreter.state import World

CELLS = 256  # a stored cell is row * CELLS + column
BITS = 32  # agents that one number of a set holds


def held_values(declared: ir.VarField, world: World) -> Any:
    """Returns the values of a field in a state: a list over cells, agents or movers, or the world's
    one value."""
    match declared.held_by.what:
        case "cell":
            return world.cells[declared.held_by.name, declared.name]
        case "agent":
            return world.agents[declared.name]
        case "mover":
            return world.movers[declared.held_by.name].fields[declared.name]
        case _:
            return world.fields[declared.name]


def stored_values(declared: ir.VarField, world: World) -> Any:
    """Returns the values of a field as the compiled state stores them, in nested lists."""
    values = held_values(declared, world)
    agents = len(world.position)
    if declared.held_by.what == "world":
        return stored(values, declared.type, agents)
    return [stored(value, declared.type, agents) for value in values]


def stored(value: Any, type_: ir.Type, agents: int) -> Any:
    """Returns a value as the compiled state stores it: enum values and agents as numbers, sets of
    agents as bits, tuples as lists.

    `agents` is their number. With more than 32, a set is a list of numbers of 32 bits.
    """
    if isinstance(value, tuple) and type_.by:
        inner = type_.model_copy(update={"by": type_.by[1:]})
        return [stored(entry, inner, agents) for entry in value]
    match type_.kind:
        case "word":
            return type_.words.index(value)
        case "agent":
            return -1 if value is None else value
        case "cell":
            return -1 if value is None else CELLS * value.row + value.col
        case "agents":
            bits = sum(1 << agent for agent in value)
            if agents <= BITS:
                return bits
            return [bits >> first & 0xFFFF_FFFF for first in range(0, agents, BITS)]
        case _:
            return value

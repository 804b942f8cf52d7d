"""Values of the interpreter as the state of the compiled game stores them."""

from typing import Any

import numpy as np

from sjdsl.compiler import ir
from sjdsl.compiler.ir.types import element
from sjdsl.interpreter.state import Cell, World

CELLS = 256  # a stored cell is row * CELLS + column
BITS = 32  # agents that one number of a set holds


def held_values(declared: ir.VarField, world: World) -> Any:
    """Returns the values of a field in a state.

    They are a list over cells, agents or movers, or the world's one value.
    """
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
    """Returns a value as the compiled state stores it.

    Enum values and agents are numbers, sets of agents bits, tuples lists. `agents` is their number:
    with more than 32, a set is a list of numbers of 32 bits.
    """
    if isinstance(value, tuple) and type_.indexed_by:
        return [stored(entry, element(type_), agents) for entry in value]
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


def loaded(array: Any, type_: ir.Type) -> Any:
    """Returns a value that the compiled state stores, or a parameter, in the interpreter's form.

    The opposite of `stored`. Reals are the same bit for bit.
    """
    if type_.indexed_by:
        return tuple(loaded(entry, element(type_)) for entry in array)
    match type_.kind:
        case "word":
            return type_.words[int(array)]
        case "agent":
            return None if array < 0 else int(array)
        case "cell":
            return None if array < 0 else Cell(*divmod(int(array), CELLS))
        case "agents":
            return frozenset(
                number * BITS + bit
                for number, bits in enumerate(np.atleast_1d(array).tolist())
                for bit in range(BITS)
                if bits >> bit & 1
            )
        case "real":
            return np.float32(array)
        case _:
            return int(array)

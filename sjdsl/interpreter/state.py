"""The whole state of a game as plain Python values, and the outcome of a step.

A word is its text, an agent its number, nobody None, a set of agents a frozenset, an integer an int, a real a numpy
float32, a cell a (row, col); a `by` field has a tuple with one value for each word, in the order of the declaration.
"""

from dataclasses import dataclass, field, replace
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np

from sjdsl.compiler import ir
from sjdsl.interpreter.numbers import real

Value: TypeAlias = Any
Facing: TypeAlias = Literal["north", "east", "south", "west", "same"]
HEADINGS = ("north", "east", "south", "west")


class Cell(NamedTuple):
    """A place on the map, rows counted from the top, columns from the left."""

    row: int
    col: int


class Mover(NamedTuple):
    """A mover, by its sort and its number among those of the sort."""

    sort: str
    number: int


class Pool(NamedTuple):
    """All sends of one phase use to one destination as written; `number` counts them within the phase."""

    phase: str
    number: int


class Away(NamedTuple):
    """Where an agent without a place waits. `ticks` to go (0: it never returns), the destination's pool, how it will face."""

    ticks: int
    pool: Pool | None
    facing: Facing | None


@dataclass
class Herd:
    """All movers of one sort, each list in the order of their numbers."""

    position: list[Cell | None]
    moved: list[bool]
    away: list[Away | None]  # None: here
    fields: dict[str, list[Value]]  # `heading` among them


@dataclass
class World:
    """One state between two steps or two phases. Lists over agents are in id order, over cells in reading order."""

    step: int
    cells: dict[tuple[str, str], list[Value]]  # (kind, field) -> a value for each cell of the kind
    agents: dict[str, list[Value]]  # field -> a value for each agent
    fields: dict[str, Value]  # the world's own fields
    position: list[Cell | None]
    heading: list[int]  # 0 north, 1 east, 2 south, 3 west
    moved: list[bool]
    away: list[Away | None]  # None: here
    marks: list[tuple[str, int, int]]  # (name of the phase, row, col)
    params: dict[str, Value]
    movers: dict[str, Herd] = field(default_factory=dict)  # by sort


@dataclass
class Outcome:
    """What a step gives beside the next state.

    events: for each event a count; a list over agents if it is counted per agent; each count a list over words if it
      has words (agents outside, words inside).
    measures: the values of `mean` and `final`, read after the last phase.
    """

    reward: list[np.float32]
    events: dict[str, Any] = field(default_factory=dict)
    measures: dict[str, Value] = field(default_factory=dict)
    truncated: bool = False
    terminated: bool = False


def copied(world: World) -> World:
    """Returns a copy whose lists can be changed without changing `world`."""
    return replace(
        world,
        cells={k: list(v) for k, v in world.cells.items()},
        agents={k: list(v) for k, v in world.agents.items()},
        fields=dict(world.fields),
        position=list(world.position),
        heading=list(world.heading),
        moved=list(world.moved),
        away=list(world.away),
        marks=list(world.marks),
        movers={sort: _copied(herd) for sort, herd in world.movers.items()},
    )


def _copied(herd: Herd) -> Herd:
    return Herd(
        list(herd.position),
        list(herd.moved),
        list(herd.away),
        {k: list(v) for k, v in herd.fields.items()},
    )


def default_params(game: ir.Game) -> dict[str, Value]:
    """Returns the declared value of every parameter; reals as float32, tables as nested tuples."""
    return {p.name: real(p.value) if p.type.kind == "real" else p.value for p in game.params}


def field_value(declared: ir.VarField, value: int | float | str | None) -> Value:
    """Returns a starting value as the state holds it, one for each word of a `by` field."""
    result: Value
    match declared.type.kind:
        case "real":
            result = np.float32(0 if value is None else value)
        case "int":
            result = 0 if value is None else value
        case "agents":
            result = frozenset()
        case _:
            result = value
    for words in reversed(declared.type.by):
        result = (result,) * len(words)
    return result

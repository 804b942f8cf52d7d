"""The whole state of a game as plain Python values, and the outcome of a step.

An enum value is its text, an agent its number, nobody None, a set of agents a frozenset, an integer
an int, a real a NumPy float32, a cell a (row, col). A `by` field has a tuple with a value for each
of its keys, in the order of the declaration.
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
    """A mover, by its entity type and its number among those of the type."""

    entity_type: str
    number: int


class Pool(NamedTuple):
    """All `send` statements of one phase to one destination as written.

    `number` counts the destinations of the phase.
    """

    phase: str
    number: int


class Away(NamedTuple):
    """How an agent or a mover is off the map."""

    ticks: int  # until it returns; 0: it never does
    pool: Pool | None  # its destination
    facing: Facing | None  # then


@dataclass
class Herd:
    """All movers of one entity type, each list in the order of their numbers."""

    position: list[Cell | None]
    moved: list[bool]
    away: list[Away | None]  # None: on the map
    fields: dict[str, list[Value]]  # with `heading`


@dataclass
class World:
    """One state between two steps or two phases.

    Lists over agents are in the order of their numbers, lists over cells in reading order.
    """

    step: int
    cells: dict[tuple[str, str], list[Value]]  # (kind, field) -> a value for each cell of the kind
    agents: dict[str, list[Value]]  # field -> a value for each agent
    fields: dict[str, Value]  # the world's own fields
    position: list[Cell | None]
    heading: list[int]  # 0 north, 1 east, 2 south, 3 west
    moved: list[bool]
    away: list[Away | None]  # None: on the map
    marks: list[tuple[str, int, int]]  # (name of the phase, row, col)
    params: dict[str, Value]
    movers: dict[str, Herd] = field(default_factory=dict)  # by entity type


@dataclass
class Outcome:
    """The results of a step beside the next state."""

    reward: list[np.float32]
    # A count for each event; a list over agents if it is counted per agent. Each count is a list
    # over keys if the event has keys.
    events: dict[str, Any] = field(default_factory=dict)
    # The values of `mean` and `final`, read after the last phase.
    measures: dict[str, Value] = field(default_factory=dict)
    truncated: bool = False
    terminated: bool = False
    # The last state of a trial that the step ended, if another trial follows in the same episode.
    last_of_trial: World | None = None

    @property
    def trial_ended(self) -> bool:
        """Whether the step was the last of a trial, or of the episode."""
        return self.truncated or self.terminated or self.last_of_trial is not None


def copied(world: World) -> World:
    """Returns a copy whose lists can be changed without changing `world`."""
    return replace(
        world,
        cells={key: list(values) for key, values in world.cells.items()},
        agents={name: list(values) for name, values in world.agents.items()},
        fields=dict(world.fields),
        position=list(world.position),
        heading=list(world.heading),
        moved=list(world.moved),
        away=list(world.away),
        marks=list(world.marks),
        movers={entity_type: _copied(herd) for entity_type, herd in world.movers.items()},
    )


def _copied(herd: Herd) -> Herd:
    """Returns movers with lists of their own."""
    return Herd(
        position=list(herd.position),
        moved=list(herd.moved),
        away=list(herd.away),
        fields={name: list(values) for name, values in herd.fields.items()},
    )


def default_params(game: ir.Game) -> dict[str, Value]:
    """Returns the declared value of every parameter; reals as float32, tables as nested tuples."""
    return {p.name: real(p.value) if p.type.kind == "real" else p.value for p in game.params}


def field_value(declared: ir.VarField, value: int | float | str | None) -> Value:
    """Returns a start value in the form of the state.

    For a `by` field, a tuple of it for all keys.
    """
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
    for index_set in reversed(declared.type.indexed_by):
        result = (result,) * len(index_set)
    return result

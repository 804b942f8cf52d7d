"""States of the interpreter as snapshots: the same pictures, without JAX and without a compiled game."""

from collections.abc import Sequence

import numpy as np

from sjdsl.compiler import ir
from sjdsl.compiler.ir.names import attribute_name
from sjdsl.compiler.ir.queries import all_fields, marking_phases
from sjdsl.interpreter.state import Cell, Value, World
from sjdsl.interpreter.step import action_mask
from sjdsl.render.snapshot import Snapshot

ROW = 256  # a stored cell is row * ROW + column
NOBODY = -1


def snapshot_of(game: ir.Game, world: World, returns: Sequence[float]) -> Snapshot:
    """Returns what a picture shows of a state of the interpreter, as `take_snapshot` does of a compiled one.

    returns: the rewards of each agent so far.
    """
    row, col = _rows_and_columns(world.position)
    masks = action_mask(game, world) if game.agents.forbids else [[True, True]] * game.agents.number
    return Snapshot(
        step=world.step,
        values={attribute_name(f): _stored(_values(f, world), f) for f in all_fields(game)},
        row=row,
        col=col,
        heading=np.array(world.heading, int),
        held=np.array([sum(mask) == 1 for mask in masks]),
        returns=np.array(returns, float),
        movers={sort: _rows_and_columns(herd.position) for sort, herd in world.movers.items()},
        marks={phase.label: _marked(phase.name, game, world) for phase in marking_phases(game)},
    )


def _values(field: ir.VarField, world: World) -> Value:
    match field.held_by:
        case "cell":
            return world.cells[field.kind, field.name]
        case "agent":
            return world.agents[field.name]
        case "mover":
            return world.movers[field.kind].fields[field.name]
        case _:
            return world.fields[field.name]


def _stored(value: Value, field: ir.VarField) -> np.ndarray:
    """Returns values as the state of the compiled game holds them: words by number, nobody and nowhere as -1, sets of agents as bits."""
    if isinstance(value, list) or (isinstance(value, tuple) and not isinstance(value, Cell)):
        return np.array([_stored(entry, field) for entry in value])
    match field.type.kind:
        case "word":
            return np.array(field.type.words.index(value))
        case "agents":
            return np.array(sum(1 << agent for agent in value), np.uint64)
        case "cell":
            return np.array(NOBODY if value is None else value.row * ROW + value.col)
        case _:
            return np.array(NOBODY if value is None else value)


def _rows_and_columns(places: Sequence[Cell | None]) -> tuple[np.ndarray, np.ndarray]:
    row, col = ([NOBODY if at is None else at[part] for at in places] for part in (0, 1))
    return np.array(row, int), np.array(col, int)


def _marked(phase: str, game: ir.Game, world: World) -> np.ndarray:
    mask = np.zeros((len(game.rows), len(game.rows[0])), bool)
    for name, row, col in world.marks:
        if name == phase and 0 <= row < mask.shape[0] and 0 <= col < mask.shape[1]:
            mask[row, col] = True
    return mask

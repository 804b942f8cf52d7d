"""States of the interpreter as snapshots: the same pictures, without JAX and without a compiled game."""

from collections.abc import Sequence

import numpy as np

from sjdsl.compiler import ir
from sjdsl.compiler.ir.names import attribute_name
from sjdsl.compiler.ir.queries import all_fields, marking_phases
from sjdsl.interpreter.state import Cell, World
from sjdsl.interpreter.step import action_mask
from sjdsl.interpreter.stored import stored_values
from sjdsl.render.snapshot import Snapshot

AWAY = -1  # row and column of who is nowhere


def snapshot_of(game: ir.Game, world: World, returns: Sequence[float]) -> Snapshot:
    """Returns what a picture shows of a state of the interpreter, as `take_snapshot` does of a compiled one.

    returns: the rewards of each agent so far.
    """
    row, col = _rows_and_columns(world.position)
    masks = action_mask(game, world) if game.agents.forbids else [[True, True]] * game.agents.number
    return Snapshot(
        step=world.step,
        values={attribute_name(f): np.array(stored_values(f, world)) for f in all_fields(game)},
        row=row,
        col=col,
        heading=np.array(world.heading, int),
        held=np.array([sum(mask) == 1 for mask in masks]),
        returns=np.array(returns, float),
        movers={sort: _rows_and_columns(herd.position) for sort, herd in world.movers.items()},
        marks={phase.label: _marked(phase.name, game, world) for phase in marking_phases(game)},
    )


def _rows_and_columns(places: Sequence[Cell | None]) -> tuple[np.ndarray, np.ndarray]:
    row, col = ([AWAY if at is None else at[part] for at in places] for part in (0, 1))
    return np.array(row, int), np.array(col, int)


def _marked(phase: str, game: ir.Game, world: World) -> np.ndarray:
    mask = np.zeros((len(game.rows), len(game.rows[0])), bool)
    for name, row, col in world.marks:
        if name == phase and 0 <= row < mask.shape[0] and 0 <= col < mask.shape[1]:
            mask[row, col] = True
    return mask

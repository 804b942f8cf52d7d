"""One state as NumPy arrays, with everything that a picture shows."""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING, Any

import numpy as np

from sjdsl.compiler.ir.queries import marking_phases

if TYPE_CHECKING:  # states of the interpreter are drawn without JAX
    from sjdsl.runtime.env import Environment


@dataclass(frozen=True)
class Snapshot:
    """One moment of an episode.

    values: attribute of the state -> array; row, col: `[N]` int, negative for agents that are away; heading: `[N]` int;
    held: `[N]` bool, agents that may only stay; returns: `[N]` float, rewards so far. movers: sort -> rows and columns of its movers,
    `[M]` int each, negative for those that are away; marks: label of a phase -> the cells it has marked in this step, `[H, W]` bool.
    """

    step: int
    values: dict[str, np.ndarray]
    row: np.ndarray
    col: np.ndarray
    heading: np.ndarray
    held: np.ndarray
    returns: np.ndarray
    movers: Mapping[str, tuple[np.ndarray, np.ndarray]] = field(default_factory=dict)
    marks: Mapping[str, np.ndarray] = field(default_factory=dict)


def take_snapshot(env: "Environment", state: Any, returns: np.ndarray) -> Snapshot:
    """Returns what a picture shows of a state of `env`."""
    import jax

    row, col = env.cells(state)
    held = np.zeros(env.num_agents, bool)
    if env.game.agents.forbids:
        held = np.asarray(env.allowed_actions(state)).sum(axis=1) == 1
    plain = jax.device_get(state)
    values = {field.name: np.asarray(getattr(plain, field.name)) for field in fields(plain)}
    return Snapshot(
        step=int(plain.step),
        values=values,
        row=np.asarray(row),
        col=np.asarray(col),
        heading=np.asarray(plain.heading),
        held=held,
        returns=np.asarray(returns),
        movers={sort.name: _cells_of(values[f"{sort.name}_position"], env) for sort in env.game.movers},
        marks={phase.label: _marked(values[f"mark_{phase.name}"], env) for phase in marking_phases(env.game)},
    )


def _cells_of(at: np.ndarray, env: "Environment") -> tuple[np.ndarray, np.ndarray]:
    """Returns rows and columns of the movers of a sort from their cells in the padded map; 0 stands for nowhere."""
    row, col = np.divmod(at.astype(int), env.module.FRAME[1])
    return np.where(at > 0, row - env.module.PAD, -1), np.where(at > 0, col - env.module.PAD, -1)


def _marked(cells: np.ndarray, env: "Environment") -> np.ndarray:
    """Returns the marked cells of the map, `[H, W]` bool, from their numbers in the padded map; 0 stands for none."""
    mask = np.zeros((len(env.game.rows), len(env.game.rows[0])), bool)
    row, col = np.divmod(cells[cells != 0], env.module.FRAME[1])
    row, col = row - env.module.PAD, col - env.module.PAD
    inside = (row >= 0) & (row < mask.shape[0]) & (col >= 0) & (col < mask.shape[1])
    mask[row[inside], col[inside]] = True
    return mask

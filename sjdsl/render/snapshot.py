"""One state as NumPy arrays, with everything that a picture shows."""

from dataclasses import dataclass, fields
from typing import Any

import jax
import numpy as np

from sjdsl.render.look import HerdLook, Look
from sjdsl.runtime.env import Environment


@dataclass(frozen=True)
class Snapshot:
    """One moment of an episode.

    values: attribute of the state -> array; row, col: `[N]` int, negative for agents that are away; heading: `[N]` int;
    held: `[N]` bool, agents that may only stay; returns: `[N]` float, rewards so far.
    """

    step: int
    values: dict[str, np.ndarray]
    row: np.ndarray
    col: np.ndarray
    heading: np.ndarray
    held: np.ndarray
    returns: np.ndarray

    def cells_of(self, herd: HerdLook, look: Look) -> tuple[np.ndarray, np.ndarray]:
        """Returns the rows and the columns of the movers of a sort, `[M]` int each, negative for those that are away."""
        at = self.values[f"{herd.name}_position"].astype(int)
        row, col = np.divmod(at, look.frame[1])
        return np.where(at > 0, row - look.pad, -1), np.where(at > 0, col - look.pad, -1)

    def marked(self, attribute: str, look: Look) -> np.ndarray:
        """Returns which cells of the map a phase has marked in this step: `[H, W]` bool."""
        cells = self.values[attribute]
        row, col = np.divmod(cells[cells != 0], look.frame[1])
        row, col = row - look.pad, col - look.pad
        inside = (row >= 0) & (row < look.height) & (col >= 0) & (col < look.width)
        mask = np.zeros((look.height, look.width), bool)
        mask[row[inside], col[inside]] = True
        return mask


def take_snapshot(env: Environment, state: Any, returns: np.ndarray) -> Snapshot:
    """Returns what a picture shows of a state of `env`."""
    row, col = env.cells(state)
    held = np.zeros(env.num_agents, bool)
    if env.game.agents.forbids:
        held = np.asarray(env.allowed_actions(state)).sum(axis=1) == 1
    plain = jax.device_get(state)
    return Snapshot(
        step=int(plain.step),
        values={field.name: np.asarray(getattr(plain, field.name)) for field in fields(plain)},
        row=np.asarray(row),
        col=np.asarray(col),
        heading=np.asarray(plain.heading),
        held=held,
        returns=np.asarray(returns),
    )

"""Shortest paths over a map: where each move leads from each cell and heading, and how many moves it takes to arrive."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import blocks_always, glyphs_of
from sjdsl.runtime.actions import DIRECTIONS, STEPS, TURNS

FAR = 65535  # no path
MOST = 20_000_000  # distances kept for one map


class TooLarge(Exception):
    """The map has too many cells for its distances to be kept."""


@dataclass(frozen=True, eq=False)
class ShortestPaths:
    """Where moves lead. A node is a cell and a heading, `4 * cell + heading`; cells are numbered row by row.

    moves: numbers of the actions that are moves, in the order of `acts`, without `stay`.
    after: `[nodes, moves]` int32, the node after each move, other agents aside. A step off the map or into a cell whose kind blocks agents
      leads nowhere; one that blocks under a condition is counted as open.
    distance: `[cells, nodes or cells]` uint16, moves from a node to a cell, FAR without a path. `headed`: whether it has a column for each
      node; if all four steps can be taken, the heading does not matter, and there is one for each cell.
    """

    width: int
    moves: tuple[int, ...]
    after: np.ndarray
    distance: np.ndarray
    headed: bool

    def column(self, node: int) -> int:
        """Returns the column of `distance` that belongs to a node."""
        return node if self.headed else node // 4


@lru_cache(maxsize=64)
def _shortest_paths(rows: tuple[str, ...], blocking: str, actions: tuple[str, ...], relative: bool, wraps: bool) -> ShortestPaths:
    height, width = len(rows), len(rows[0])
    moves = tuple(i for i, a in enumerate(actions) if a in STEPS or a in TURNS)
    headed = relative and not set(STEPS) <= set(actions)
    cells = height * width
    if cells * cells * (4 if headed else 1) > MOST:
        raise TooLarge(f"`seek` on a map of {cells} cells")
    after = _after(rows, blocking, actions, moves, relative, wraps)
    steps = after if headed else after[::4] // 4  # facing north: all four directions are among the moves
    return ShortestPaths(width, moves, after, _distances(steps, cells, headed), headed)


def shortest_paths_of(game: ir.Game) -> ShortestPaths:
    """Returns the shortest paths over a game's map. Raises TooLarge."""
    return _shortest_paths(game.rows, _blocking(game), game.agents.actions, game.agents.relative, game.wraps)


def _blocking(game: ir.Game) -> str:
    """Returns the glyphs of cells that agents can never enter."""
    return glyphs_of(game, tuple(kind.name for kind in game.kinds if blocks_always(kind)))


def _after(
    rows: tuple[str, ...], blocking: str, actions: tuple[str, ...], moves: tuple[int, ...], relative: bool, wraps: bool
) -> np.ndarray:
    height, width = len(rows), len(rows[0])
    open_ = np.array([[glyph not in blocking for glyph in row] for row in rows])
    row, col, heading = np.meshgrid(np.arange(height), np.arange(width), np.arange(4), indexing="ij")
    columns = []
    for move in moves:
        name = actions[move]
        turned = (heading + TURNS.get(name, 0)) % 4
        if name in TURNS:
            columns.append((row * width + col) * 4 + turned)
            continue
        direction = (heading * relative + STEPS[name]) % 4
        r = row + np.array([d[0] for d in DIRECTIONS])[direction]
        c = col + np.array([d[1] for d in DIRECTIONS])[direction]
        r, c = (r % height, c % width) if wraps else (r, c)
        inside = (r >= 0) & (r < height) & (c >= 0) & (c < width)
        free = inside & open_[np.clip(r, 0, height - 1), np.clip(c, 0, width - 1)]
        columns.append((np.where(free, r, row) * width + np.where(free, c, col)) * 4 + turned)
    return (
        np.stack(columns, axis=-1).reshape(height * width * 4, len(moves)).astype(np.int32)
        if moves
        else np.zeros((height * width * 4, 0), np.int32)
    )


def _distances(after: np.ndarray, cells: int, headed: bool) -> np.ndarray:
    """Returns distances by breadth-first search: one more move at a time, from all nodes to all cells at once."""
    there = np.arange(after.shape[0]) // (4 if headed else 1)
    distance = np.where(np.arange(cells)[:, None] == there[None], 0, FAR).astype(np.uint16)
    for moves in range(1, FAR):
        nearer = distance == moves - 1
        reached = np.zeros_like(nearer)
        for column in range(after.shape[1]):
            reached |= nearer[:, after[:, column]]
        reached &= distance == FAR
        if not reached.any():
            break
        distance[reached] = moves
    return distance

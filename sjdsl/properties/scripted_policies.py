"""Policies of `expect` on the interpreter, `random`, `never(…)`, `seek …` and those of the file; and shortest paths over a map, for those that seek."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import blocks_always, glyphs_of
from sjdsl.interpreter.board import board_of
from sjdsl.interpreter.bodies import where_is
from sjdsl.interpreter.evaluate import members_of
from sjdsl.interpreter.instance import Instance
from sjdsl.interpreter.state import Cell, World
from sjdsl.policies import interpreted
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


WANDERS = 8  # one move in so many of a seeking agent is random, so that two that meet in a passage part again


def allowed_by(policy: ir.Policy, game: ir.Game) -> tuple[int, ...]:
    """Returns the actions among which `random` and `never` choose, all equally likely; `stay` if none is left."""
    left = tuple(a for a in range(len(game.agents.actions)) if a not in policy.actions)
    return left or (game.agents.actions.index("stay"),)


def choose(policy: ir.Policy, game: ir.Game, world: World, agent: int, bits: tuple[int, int]) -> int:
    """Returns what an agent with this policy does in a state."""
    if policy.name == "scripted":
        return interpreted.choose(policy_named(game, policy.scripted), game, world, agent, bits)
    if policy.domain is None:
        actions = allowed_by(policy, game)
        return actions[bits[0] * len(actions) >> 32]
    paths = shortest_paths_of(game)
    wandering = bits[1] * WANDERS >> 32 == 0
    cell, stay = world.position[agent], game.agents.actions.index("stay")
    if cell is None or not paths.moves:
        return stay
    wanted = () if wandering else _cells_of(policy.domain, game, world, agent)
    move = towards(paths, node_of(paths, cell, world.heading[agent]), [c.row * paths.width + c.col for c in wanted])
    if move is not None:
        return stay if move < 0 else move
    return paths.moves[bits[0] * len(paths.moves) >> 32]


def policy_named(game: ir.Game, name: str) -> ir.ScriptedPolicy:
    """Returns a policy that the game's file declares."""
    return next(policy for policy in game.policies if policy.name == name)


def node_of(paths: ShortestPaths, cell: Cell, heading: int) -> int:
    """Returns the node of an agent."""
    return (cell.row * paths.width + cell.col) * 4 + heading


def towards(paths: ShortestPaths, node: int, cells: Sequence[int]) -> int | None:
    """Returns the first move of a shortest path to the nearest of the cells, -1 on the spot, None if no path leads to any.

    Of cells equally near the first counts, of moves equally good the first in the order of `acts`.
    """
    here = paths.column(node)
    distances = [int(paths.distance[cell, here]) for cell in cells]
    nearest = min(distances, default=FAR)
    if nearest == FAR:
        return None
    if nearest == 0:
        return -1
    target = cells[distances.index(nearest)]
    after = [int(paths.distance[target, paths.column(int(n))]) for n in paths.after[node]]
    return paths.moves[after.index(min(after))]


def _cells_of(domain: ir.Domain, game: ir.Game, world: World, agent: int) -> list[Cell]:
    """Returns the cells of the members of a domain, for the agent that walks, in the order of their numbers."""
    here = Instance(board_of(game), world, names={"agent": agent})
    found = [m.member for m in members_of(domain, here)]
    cells = [m if isinstance(m, Cell) else where_is(m, world) for m in found]
    return [cell for cell in cells if cell is not None]

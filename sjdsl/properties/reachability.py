"""Reachability of cells: how many moves an agent needs to stand on a cell, or to have it in a shape such as a beam."""

from collections.abc import Collection
from functools import lru_cache

import numpy as np

from sjdsl.interpreter.board import Board
from sjdsl.interpreter.bodies import occupied
from sjdsl.interpreter.evaluate import is_blocked
from sjdsl.interpreter.instance import Instance
from sjdsl.interpreter.shapes import place_at
from sjdsl.interpreter.state import Cell, World
from sjdsl.properties.shortest_paths import FAR, moves_of, moves_to


def node_of(agent: int, world: World, board: Board) -> int | None:
    """Returns the cell and heading of an agent as one number, see `shortest_paths.ShortestPaths`; None for an agent that is away."""
    cell = world.position[agent]
    return None if cell is None else _number(cell, board) * 4 + world.heading[agent]


def others_of(agent: int, world: World) -> frozenset[Cell]:
    """Returns the cells on which other agents, or movers, are."""
    return frozenset(occupied(world, (agent,)))


def closed_to(agent: int, world: World, board: Board) -> frozenset[Cell]:
    """Returns the cells that an agent cannot enter now: their kinds block agents under a condition that holds."""
    cells = _closing(board)
    if not cells:
        return frozenset()
    here = Instance(board, world)
    return frozenset(cell for cell in cells if is_blocked(cell, "agents", agent, here))


@lru_cache(maxsize=64)
def _closing(board: Board) -> tuple[Cell, ...]:
    kinds = [k.name for k in board.kinds.values() if any(b.what == "agents" and b.condition is not None for b in k.blocks)]
    return tuple(cell for kind in kinds for cell in board.cells[kind])


@lru_cache(maxsize=4096)
def moves_until(
    board: Board, cell: Cell, shape: str | None = None, at: Cell | None = None, around: frozenset[Cell] = frozenset()
) -> np.ndarray:
    """Returns from each node the number of moves until an agent stands on a cell, or has it in a shape; walls aside. FAR without a path.

    at: where it has to stand; None: anywhere. around: cells that cannot be entered now, because others are there.
    """
    nodes = _goals_at(board, cell, shape, at)
    after = _moves_around(board, around)
    return moves_to(nodes, after) if nodes else np.full(after.shape[0], FAR, np.int64)


@lru_cache(maxsize=1024)
def moves_from(board: Board, node: int, around: frozenset[Cell] = frozenset()) -> np.ndarray:
    """Returns how many moves it takes from a node to each node, `[nodes]` int64; FAR without a path. around: see `moves_until`."""
    after = _moves_around(board, around)
    distance = np.full(after.shape[0], FAR, np.int64)
    front = np.array([node])
    for moves in range(FAR):
        distance[front] = moves
        reached = after[front].reshape(-1)
        front = np.unique(reached[distance[reached] == FAR])
        if not front.size:
            break
    return distance


def least_moves(board: Board, node: int, cells: Collection[Cell], shape: str | None, around: frozenset[Cell]) -> int:
    """Returns the moves from a node until an agent stands on one of some cells, or has it in a shape, as `moves_until` counts them."""
    goals = [goal for cell in cells for goal in _goals(cell, shape, board)]
    return int(moves_from(board, node, around)[goals].min()) if goals else FAR


@lru_cache(maxsize=2048)
def stands(board: Board, cell: Cell, shape: str | None = None) -> tuple[Cell, ...]:
    """Returns the cells that agents can enter and from which they reach a cell."""
    width = len(board.game.rows[0])
    found = dict.fromkeys(Cell(*divmod(node // 4, width)) for node in _goals(cell, shape, board))
    return tuple(
        stand for stand in found if not any(b.what == "agents" and b.condition is None for b in board.kinds[board.kind_of[stand]].blocks)
    )


def can_go(
    node: int | None, board: Board, cell: Cell, shape: str | None = None, at: Cell | None = None, around: frozenset[Cell] = frozenset()
) -> bool:
    """Returns whether there is a path from a node, as `moves_until` counts; True for an agent that is away."""
    return node is None or bool((moves_from(board, node, around)[_goals_at(board, cell, shape, at)] < FAR).any())


@lru_cache(maxsize=256)
def _moves_around(board: Board, around: frozenset[Cell]) -> np.ndarray:
    """Returns where moves lead, `shortest_paths.ShortestPaths.after`; moves into some cells lead nowhere."""
    after = moves_of(board.game)[1]
    if not around:
        return after
    taken = np.zeros(after.shape[0], np.bool_)
    taken.reshape(-1, 4)[[_number(cell, board) for cell in around]] = True
    return np.where(taken[after], np.arange(after.shape[0])[:, None], after)


@lru_cache(maxsize=2048)
def _goals(cell: Cell, shape: str | None, board: Board) -> list[int]:
    return _nodes_on(cell, board) if shape is None else _nodes_around(cell, shape, board)


def _goals_at(board: Board, cell: Cell, shape: str | None, at: Cell | None) -> list[int]:
    """Returns the nodes on a cell, or from which a shape reaches it; those on `at`, if that is given."""
    return [node for node in _goals(cell, shape, board) if at is None or node // 4 == _number(at, board)]


def _number(cell: Cell, board: Board) -> int:
    return cell.row * len(board.game.rows[0]) + cell.col


def _nodes_on(cell: Cell, board: Board) -> list[int]:
    return [_number(cell, board) * 4 + heading for heading in range(4)]


def _nodes_around(target: Cell, shape: str, board: Board) -> list[int]:
    """Returns the nodes from which a shape reaches a cell if nothing is in between."""
    declared, found = board.shapes[shape], []
    for lane in declared.lanes:
        for ahead, right in lane:
            for heading in range(4):
                turned = heading if declared.directed else 0
                origin = board.at(*place_at(target, turned, -ahead, -right))
                if origin is not None and origin != target:
                    found.append(_number(origin, board) * 4 + heading)
    return found

"""Scripted policies on the interpreter: what an agent does in a state, by the first rule that applies, with two random numbers."""

from collections import deque
from collections.abc import Collection, Iterator
from dataclasses import dataclass, field
from functools import lru_cache
from typing import NamedTuple

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import action_named, blocks_always
from sjdsl.interpreter.board import Board, board_of
from sjdsl.interpreter.bodies import occupied, where_is
from sjdsl.interpreter.evaluate import arguments_of, evaluate, members_of
from sjdsl.interpreter.instance import Instance
from sjdsl.interpreter.movement import STEPS, TURNS
from sjdsl.interpreter.shapes import FORWARD, lanes_from
from sjdsl.interpreter.state import Cell, World


class Pose(NamedTuple):
    """Where an agent stands, and its heading."""

    cell: Cell
    heading: int


@dataclass(frozen=True, eq=False)
class Ground:
    """The cells that agents can ever enter, the names of the moves by the numbers of their actions, and the poses before each pose."""

    board: Board
    open: frozenset[Cell]
    moves: dict[int, str]
    before: dict[Pose, list[Pose]] = field(default_factory=dict)

    def after(self, move: str, pose: Pose) -> Pose:
        """Returns where a move leads, whether or not the cell can be entered."""
        if move in TURNS:
            return Pose(pose.cell, (pose.heading + TURNS[move]) % 4)
        turned = pose.heading if self.board.game.agents.relative else 0
        rows, cols = FORWARD[(turned + STEPS[move]) % 4]
        row, col = pose.cell.row + rows, pose.cell.col + cols
        return Pose(self.board.at(row, col) or Cell(row, col), pose.heading)


@lru_cache(maxsize=16)
def _ground_of(board: Board) -> Ground:
    actions = board.game.agents.actions
    moves = {number: name for number, name in enumerate(actions) if name in TURNS or name in STEPS}
    open_ = frozenset(
        cell for cell, kind in board.kind_of.items() if not blocks_always(board.kinds[kind])
    )
    ground = Ground(board, open_, moves)
    for pose in (Pose(cell, heading) for cell in board.kind_of for heading in range(4)):
        for move in moves.values():
            ground.before.setdefault(ground.after(move, pose), []).append(pose)
    return ground


def choose(
    policy: ir.ScriptedPolicy, game: ir.Game, world: World, agent: int, bits: tuple[int, int]
) -> int:
    """Returns the number of the action that an agent takes.

    Args:
      bits: two random 32-bit numbers, used only where another agent stands in the way.
    """
    board = board_of(game)
    stay = game.agents.actions.index("stay")
    here = Instance(board, world, names={"agent": agent})
    cell = world.position[agent]
    if cell is None:
        return stay
    for rule in policy.rules:
        match rule:
            case ir.Act():
                if evaluate(rule.condition, here):
                    return _taken(rule, here)
            case ir.Go() | ir.Aim():
                taken = _towards(rule, here, Pose(cell, world.heading[agent]), bits, stay)
                if taken is not None:
                    return taken
    return stay


def _towards(
    rule: ir.Go | ir.Aim, here: Instance, pose: Pose, bits: tuple[int, int], stay: int
) -> int | None:
    """Returns the action by which a rule is followed; None if it does not apply, for no path leads to a goal."""
    ground = _ground_of(here.board)
    members = set(_cells_of(rule.domain, here))
    closed = set() if rule.avoided is None else set(_cells_of(rule.avoided, here))
    if isinstance(rule, ir.Go):
        enterable = ground.open - (closed - members)
        goals = {Pose(cell, heading) for cell in members for heading in range(4)}
        done = stay
    else:
        enterable = ground.open - closed
        reached = _reached(
            ground.board, rule.shape
        ).items()  # what blocks the shape under a condition is not considered
        goals = {aimed for aimed, cells in reached if not cells.isdisjoint(members)}
        done = _taken(rule, here)
    if pose in goals:
        return done
    distance = _distances(ground, goals, enterable)
    if pose not in distance:
        return None
    return _move(ground, pose, distance, enterable, here, bits)


def _taken(rule: ir.Act | ir.Aim, here: Instance) -> int:
    """Returns the number of the action that a rule ends in."""
    if not rule.chosen:
        return rule.action
    action = action_named(here.board.game, rule.chosen)
    wanted = tuple(evaluate(given.value, here) for given in rule.given)
    return next(number for number in action.numbers if arguments_of(action, number) == wanted)


def _cells_of(domain: ir.Domain, here: Instance) -> Iterator[Cell]:
    for found in members_of(domain, here):
        cell = (
            found.member if isinstance(found.member, Cell) else where_is(found.member, here.world)
        )
        if cell is not None:
            yield cell


@lru_cache(maxsize=16)
def _reached(board: Board, name: str) -> dict[Pose, frozenset[Cell]]:
    """Returns the cells of a shape that are reached from each pose."""
    shape = board.shapes[name]
    stopping = {
        cell for cell, kind in board.kind_of.items() if blocks_always(board.kinds[kind], name)
    }
    found = {}
    for pose in (Pose(cell, heading) for cell in board.kind_of for heading in range(4)):
        lanes = lanes_from(
            shape, pose.cell, pose.heading if shape.directed else 0, board.at, stopping.__contains__
        )
        found[pose] = frozenset(seen.cell for lane in lanes for seen in lane)
    return found


def _distances(
    ground: Ground, goals: Collection[Pose], enterable: Collection[Cell]
) -> dict[Pose, int]:
    """Returns how many moves it takes from each pose to a goal, of those from which one can be reached."""
    distance = dict.fromkeys(goals, 0)
    waiting = deque(goals)
    while waiting:
        pose = waiting.popleft()
        for earlier in ground.before.get(pose, ()):
            if earlier not in distance and (earlier.cell == pose.cell or pose.cell in enterable):
                distance[earlier] = distance[pose] + 1
                waiting.append(earlier)
    return distance


def _move(
    ground: Ground,
    pose: Pose,
    distance: dict[Pose, int],
    enterable: Collection[Cell],
    here: Instance,
    bits: tuple[int, int],
) -> int:
    """Returns the first of the moves that lead nearest; where another agent or a mover is in the way, one of all moves half of the time."""
    ways = {number: ground.after(name, pose) for number, name in ground.moves.items()}
    ways = {
        number: after
        for number, after in ways.items()
        if after.cell == pose.cell or after.cell in enterable
    }
    best = min(
        (number for number, after in ways.items() if after in distance),
        key=lambda number: (distance[ways[number]], number),
    )
    others = occupied(here.world, without={here.names["agent"]})
    if ways[best].cell not in others or bits[1] >= 1 << 31:
        return best
    return list(ways)[bits[0] * len(ways) >> 32]

"""Scripted policies on the interpreter: an agent follows the first rule that applies."""

from collections import deque
from collections.abc import Collection, Iterator
from dataclasses import dataclass, field
from functools import lru_cache
from typing import NamedTuple

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import action_named, blocks_always, closes_paths
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
class WalkMap:
    """Where agents can go on a board.

    open: the cells that agents can ever enter; moves: number of an action -> name of its move;
    poses_before: a pose -> the poses from which one move leads there.
    """

    board: Board
    open: frozenset[Cell]
    moves: dict[int, str]
    poses_before: dict[Pose, list[Pose]] = field(default_factory=dict)

    def pose_after(self, move: str, pose: Pose) -> Pose:
        """Returns where a move leads, whether or not the cell can be entered."""
        if move in TURNS:
            return Pose(pose.cell, (pose.heading + TURNS[move]) % 4)
        heading = pose.heading if self.board.game.agents.relative else 0
        down, right = FORWARD[(heading + STEPS[move]) % 4]
        cell = Cell(pose.cell.row + down, pose.cell.col + right)
        return Pose(self.board.at(cell.row, cell.col) or cell, pose.heading)


@lru_cache(maxsize=16)
def _walk_map_of(board: Board) -> WalkMap:
    """Returns where agents can go on a board, and the poses before each pose."""
    actions = board.game.agents.actions
    moves = {number: name for number, name in enumerate(actions) if name in TURNS or name in STEPS}
    open_cells = frozenset(
        cell for cell, kind in board.kind_of.items() if not blocks_always(board.kinds[kind])
    )
    walk_map = WalkMap(board, open_cells, moves)
    for pose in _poses(board):
        for move in moves.values():
            walk_map.poses_before.setdefault(walk_map.pose_after(move, pose), []).append(pose)
    return walk_map


def _poses(board: Board) -> Iterator[Pose]:
    """Yields each cell with each heading."""
    for cell in board.kind_of:
        for heading in range(4):
            yield Pose(cell, heading)


def choose(
    policy: ir.ScriptedPolicy, game: ir.Game, world: World, agent: int, bits: tuple[int, int]
) -> int:
    """Returns the number of the action that an agent takes.

    Args:
      bits: twice 32 random bits, used only if somebody stands in the way.
    """
    stay = game.agents.actions.index("stay")
    instance = Instance(board_of(game), world, names={"agent": agent})
    cell = world.position[agent]
    if cell is None:
        return stay
    for rule in policy.rules:
        inner = instance
        if rule.on is not None:
            if instance.board.kind_of[cell] not in rule.on.kinds:
                continue
            inner = instance.binding({rule.on.name: cell})
        if rule.condition is not None and not evaluate(rule.condition, inner):
            continue
        match rule:
            case ir.Act():
                return _final_action(rule, inner)
            case ir.Go() | ir.Aim():
                pose = Pose(cell, world.heading[agent])
                action = _go_towards(rule, inner, pose, bits, stay)
                if action is not None:
                    return action
    return stay


def _go_towards(
    rule: ir.Go | ir.Aim, instance: Instance, pose: Pose, bits: tuple[int, int], stay: int
) -> int | None:
    """Returns the action with which a rule is followed, None if no path leads to a goal."""
    walk_map = _walk_map_of(instance.board)
    members = set(_cells_of(rule.domain, instance))
    avoided = set() if rule.avoided is None else set(_cells_of(rule.avoided, instance))
    closed = set(_closed_cells(instance))
    if isinstance(rule, ir.Go):
        enterable = walk_map.open - closed - (avoided - members)
        goals = {Pose(cell, heading) for cell in members for heading in range(4)}
        at_goal = stay
    else:
        enterable = walk_map.open - closed - avoided
        reached = _reached_cells(walk_map.board, rule.shape)
        goals = {aiming for aiming, cells in reached.items() if not cells.isdisjoint(members)}
        at_goal = _final_action(rule, instance)
    if pose in goals:
        return at_goal
    distance = _distances(walk_map, goals, enterable)
    if pose not in distance:
        return None
    return _choose_move(walk_map, pose, distance, enterable, instance, bits)


def _final_action(rule: ir.Act | ir.Aim, instance: Instance) -> int:
    """Returns the number of the action that a rule leads to."""
    if not rule.chosen:
        return rule.action
    action = action_named(instance.board.game, rule.chosen)
    arguments = tuple(evaluate(argument.value, instance) for argument in rule.given)
    return next(number for number in action.numbers if arguments_of(action, number) == arguments)


def _closed_cells(instance: Instance) -> Iterator[Cell]:
    """Yields the cells that block the agent by what it is, and so close its path."""
    agent = instance.names["agent"]
    for name, kind in instance.board.kinds.items():
        conditions = [
            block.condition
            for block in kind.blocks
            if block.condition is not None and closes_paths(block)
        ]
        if not conditions:
            continue
        for cell in instance.board.cells[name]:
            seen = instance.only({name: cell, "agent": agent})
            if any(evaluate(condition, seen) for condition in conditions):
                yield cell


def _cells_of(domain: ir.Domain, instance: Instance) -> Iterator[Cell]:
    """Yields the cells of a domain, or those on which its agents and movers stand."""
    for bound in members_of(domain, instance):
        member = bound.member
        cell = member if isinstance(member, Cell) else where_is(member, instance.world)
        if cell is not None:
            yield cell


@lru_cache(maxsize=16)
def _reached_cells(board: Board, name: str) -> dict[Pose, frozenset[Cell]]:
    """Returns the cells that a shape reaches from each pose.

    Cells that block it under a condition don't count as blocking.
    """
    shape = board.shapes[name]
    blocking = {
        cell for cell, kind in board.kind_of.items() if blocks_always(board.kinds[kind], name)
    }
    reached = {}
    for pose in _poses(board):
        heading = pose.heading if shape.directed else 0
        lanes = lanes_from(shape, pose.cell, heading, board.at, blocking.__contains__)
        reached[pose] = frozenset(place.cell for lane in lanes for place in lane)
    return reached


def _distances(
    walk_map: WalkMap, goals: Collection[Pose], enterable: Collection[Cell]
) -> dict[Pose, int]:
    """Returns the number of moves to a goal from each pose from which there is a path."""
    distance = dict.fromkeys(goals, 0)
    waiting = deque(goals)
    while waiting:
        pose = waiting.popleft()
        for earlier in walk_map.poses_before.get(pose, ()):
            if earlier not in distance and (earlier.cell == pose.cell or pose.cell in enterable):
                distance[earlier] = distance[pose] + 1
                waiting.append(earlier)
    return distance


def _choose_move(
    walk_map: WalkMap,
    pose: Pose,
    distance: dict[Pose, int],
    enterable: Collection[Cell],
    instance: Instance,
    bits: tuple[int, int],
) -> int:
    """Returns the action of the first move that leads nearest to a goal.

    If an agent or a mover is in the way, half of the time it is one of all allowed moves.
    """
    allowed: dict[int, Pose] = {}
    for number, name in walk_map.moves.items():
        after = walk_map.pose_after(name, pose)
        if after.cell == pose.cell or after.cell in enterable:
            allowed[number] = after
    best = min(
        (number for number, after in allowed.items() if after in distance),
        key=lambda number: (distance[allowed[number]], number),
    )
    others = occupied(instance.world, without={instance.names["agent"]})
    takes_any = bits[1] < 1 << 31
    if allowed[best].cell not in others or not takes_any:
        return best
    drawn = bits[0] * len(allowed) >> 32  # of 32 random bits, a number below that of the moves
    return list(allowed)[drawn]

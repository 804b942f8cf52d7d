"""Drives agents during test play: by habit at random, or towards goals, alone or together."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from random import Random

import numpy as np

from sjdsl.compiler import ir
from sjdsl.interpreter.board import board_of
from sjdsl.interpreter.state import Cell, World
from sjdsl.properties.goal_assignment import AgentGoal, assign_goals, ordinary
from sjdsl.properties.preconditions import Goal, Precondition
from sjdsl.properties.reachability import closed_to, node_of, others_of
from sjdsl.properties.shortest_paths import FAR, moves_of
from sjdsl.properties.statements import StatementId

HABIT = 0.5  # how often an agent takes its habitual action
QUIET = 0.85  # how often agents without a goal only move while others have one
ASTRAY = 0.1  # how often an agent on its way takes another move, so that two that meet in a passage part again
WAITS = 4  # steps that agents wait for each other, beyond those that the last of them takes to arrive


@dataclass
class GuidedDriver:
    """Chooses the actions of all agents for a number of steps.

    habits: the action each agent often takes. goal: the statement that is to run; it is over when all agents have done their part.
    agent_goals: of some agents. together: they wait until all have arrived, or until step `patience`.
    """

    game: ir.Game
    random: Random
    steps: int
    habits: Sequence[int]
    moves: Sequence[int]
    preconditions: Sequence[Precondition]
    ran: Counter[StatementId]
    goal: Goal | None = None
    agent_goals: dict[int, AgentGoal] = field(default_factory=dict)
    together: bool = False
    quiet: bool = False
    patience: int = 0
    _taken: int = 0
    _shortest_paths: dict[int, np.ndarray] = field(default_factory=dict)  # of this step

    def __call__(self, world: World, number: int) -> tuple[int, ...] | None:
        """Returns an action for each agent; None at the end, and when all agents with goals are done."""
        del number
        if self._taken >= self.steps:
            return None
        done = not any(e.times for e in self.agent_goals.values())
        if self.goal is not None and done and self._taken:
            return None
        if self.goal is not None and done:
            assignment = assign_goals(self.game, self.goal, self.preconditions, self.ran, world, self.random)
            self.agent_goals, self.together, self.patience = (
                assignment.agent_goals,
                assignment.together,
                self._taken + assignment.longest + WAITS,
            )
        for agent_goal in self.agent_goals.values():
            agent_goal.follow(world)
        self._taken += 1
        self._shortest_paths = {}
        arrived = {agent: self._has_arrived(agent, world) for agent in self.agent_goals}
        wanted = {cell for agent, there in arrived.items() if not there and (cell := self._next_cell(agent, world)) is not None}
        all_there = all(arrived.values())
        if self.goal is not None and self.goal.many > 1 and self.together and not all_there and self._taken > self.patience:
            return None  # acting alone would only spoil the goal
        now = not self.together or all_there or self._taken > self.patience
        if self.together and now:
            self.patience = 0
        return tuple(
            self._towards_goal(agent, world, arrived[agent], now)
            if agent in self.agent_goals
            else self._make_room(agent, world)
            if world.position[agent] in wanted
            else self._by_habit(agent)
            for agent in range(self.game.agents.number)
        )

    def _by_habit(self, agent: int) -> int:
        if self.quiet:
            return self.random.choice(self.moves)
        if self.random.random() < HABIT:
            return self.habits[agent]
        return self.random.randrange(len(self.game.agents.actions))

    def _node(self, agent: int, world: World) -> int | None:
        return node_of(agent, world, board_of(self.game))

    def _has_arrived(self, agent: int, world: World) -> bool:
        node = self._node(agent, world)
        return node is not None and self.agent_goals[agent].distance[node] == 0

    def _towards_goal(self, agent: int, world: World, arrived: bool, now: bool) -> int:
        agent_goal, node, stay = self.agent_goals[agent], self._node(agent, world), self.game.agents.actions.index("stay")
        if not agent_goal.times:
            return self._by_habit(agent)
        if node is None or (arrived and not now):
            return stay
        if arrived or (now and self.together):
            agent_goal.times -= 1
            return agent_goal.action
        moves, after = moves_of(self.game)
        if not moves or self.random.random() < ASTRAY or agent_goal.distance[node] >= FAR:
            return self.random.choice(moves) if moves else stay
        distance = self._distance(agent, world)
        return moves[int(np.argmin(distance[after[node]]))]

    def _distance(self, agent: int, world: World) -> np.ndarray:
        """Returns the distance of an agent's goal from each node: around others and closed cells if there is such a path, or past them."""
        if agent not in self._shortest_paths:
            self._shortest_paths[agent] = self._find_path(agent, world)
        return self._shortest_paths[agent]

    def _find_path(self, agent: int, world: World) -> np.ndarray:
        agent_goal, node = self.agent_goals[agent], self._node(agent, world)
        closed, others = closed_to(agent, world, board_of(self.game)), others_of(agent, world)
        paths = (agent_goal.distance_around(cells) for cells in dict.fromkeys((closed | others, closed)))
        return next((path for path in paths if node is not None and path[node] < FAR), agent_goal.distance)

    def _next_cell(self, agent: int, world: World) -> Cell | None:
        """Returns the cell that an agent with a goal enters next, if it is another than its own."""
        node, (moves, after), width = self._node(agent, world), moves_of(self.game), len(self.game.rows[0])
        if node is None or not moves:
            return None
        distance = self._distance(agent, world)
        cell = Cell(*divmod(int(after[node][np.argmin(distance[after[node]])]) // 4, width))
        return None if cell == world.position[agent] else cell

    def _make_room(self, agent: int, world: World) -> int:
        """Returns a move by which an agent leaves its cell, or one after which it can."""
        node, (moves, after) = self._node(agent, world), moves_of(self.game)
        leaving = [] if node is None else [move for move, to in zip(moves, after[node], strict=True) if to // 4 != node // 4]
        return self.random.choice(leaving or self.moves)


def guided_driver(
    game: ir.Game, preconditions: Sequence[Precondition], goal: Goal | None, ran: Counter[StatementId], steps: int, random: Random
) -> GuidedDriver:
    """Returns a driver of all agents for so many steps at most."""
    count = len(game.agents.actions)
    moves = ordinary(game)
    special = [a for a in range(count) if a not in moves]
    habits = [random.choice((special if special and random.random() < HABIT else None) or range(count)) for _ in range(game.agents.number)]
    return GuidedDriver(game, random, steps, habits, moves, preconditions, ran, goal, quiet=goal is not None and random.random() < QUIET)

"""What agents do in a stretch of a course: habits, or errands: to go where a sentence can take place and act there, alone or together."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from random import Random

import numpy as np

from sjdsl.compiler import ir
from sjdsl.interpreter.board import board_of
from sjdsl.interpreter.state import Cell, World
from sjdsl.properties.goal_assignment import Errand, ordinary, send_out
from sjdsl.properties.preconditions import Goal, Recipe
from sjdsl.properties.reachability import closed_to, node_of, others_of
from sjdsl.properties.shortest_paths import FAR, moves_of
from sjdsl.properties.statements import Place

HABIT = 0.5  # how often an agent does what it always does
QUIET = 0.85  # how often those who have no errand only move while others have
ASTRAY = 0.1  # how often one on the way takes another move, so that two who meet in a passage part again
WAITS = 4  # steps for which those who wait for each other do so, beyond those that the way of the last of them takes


@dataclass
class Stretch:
    """Drives the agents for a number of steps.

    habits: the action each agent often takes. goal: for what agents are sent out; it is over when their errands are.
    errands: of some agents. together: they wait until all have arrived, or until step `patience` of the stretch.
    """

    game: ir.Game
    random: Random
    steps: int
    habits: Sequence[int]
    moves: Sequence[int]
    recipes: Sequence[Recipe]
    ran: Counter[Place]
    goal: Goal | None = None
    errands: dict[int, Errand] = field(default_factory=dict)
    together: bool = False
    quiet: bool = False
    patience: int = 0
    _taken: int = 0
    _ways: dict[int, np.ndarray] = field(default_factory=dict)  # of this step

    def __call__(self, world: World, number: int) -> tuple[int, ...] | None:
        """Returns an action for each agent; None at the end, and when all errands are done."""
        del number
        if self._taken >= self.steps:
            return None
        done = not any(e.times for e in self.errands.values())
        if self.goal is not None and done and self._taken:
            return None
        if self.goal is not None and done:
            sent = send_out(self.game, self.goal, self.recipes, self.ran, world, self.random)
            self.errands, self.together, self.patience = sent.errands, sent.together, self._taken + sent.longest + WAITS
        self._taken += 1
        self._ways = {}
        arrived = {agent: self._has_arrived(agent, world) for agent in self.errands}
        wanted = {cell for agent, there in arrived.items() if not there and (cell := self._next_cell(agent, world)) is not None}
        all_there = all(arrived.values())
        if self.goal is not None and self.goal.many > 1 and self.together and not all_there and self._taken > self.patience:
            return None  # one alone would only spoil it
        now = not self.together or all_there or self._taken > self.patience
        if self.together and now:
            self.patience = 0
        return tuple(
            self._on_errand(agent, world, arrived[agent], now)
            if agent in self.errands
            else self._out_of_the_way(agent, world)
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
        return node is not None and self.errands[agent].distance[node] == 0

    def _on_errand(self, agent: int, world: World, arrived: bool, now: bool) -> int:
        errand, node, stay = self.errands[agent], self._node(agent, world), self.game.agents.actions.index("stay")
        if not errand.times:
            return self._by_habit(agent)
        if node is None or (arrived and not now):
            return stay
        if arrived or (now and self.together):
            errand.times -= 1
            return errand.action
        moves, after = moves_of(self.game)
        if not moves or self.random.random() < ASTRAY or errand.distance[node] >= FAR:
            return self.random.choice(moves) if moves else stay
        distance = self._distance(agent, world)
        return moves[int(np.argmin(distance[after[node]]))]

    def _distance(self, agent: int, world: World) -> np.ndarray:
        """Returns how far the errand of an agent is from each node: around others and what is closed if there is such a way; or past them."""
        if agent not in self._ways:
            self._ways[agent] = self._find_way(agent, world)
        return self._ways[agent]

    def _find_way(self, agent: int, world: World) -> np.ndarray:
        errand, node = self.errands[agent], self._node(agent, world)
        closed, others = closed_to(agent, world, board_of(self.game)), others_of(agent, world)
        ways = (errand.distance_around(cells) for cells in dict.fromkeys((closed | others, closed)))
        return next((way for way in ways if node is not None and way[node] < FAR), errand.distance)

    def _next_cell(self, agent: int, world: World) -> Cell | None:
        """Returns the cell that an agent on an errand enters next, if it is another than its own."""
        node, (moves, after), width = self._node(agent, world), moves_of(self.game), len(self.game.rows[0])
        if node is None or not moves:
            return None
        distance = self._distance(agent, world)
        cell = Cell(*divmod(int(after[node][np.argmin(distance[after[node]])]) // 4, width))
        return None if cell == world.position[agent] else cell

    def _out_of_the_way(self, agent: int, world: World) -> int:
        """Returns a move by which an agent leaves its cell, or one after which it can."""
        node, (moves, after) = self._node(agent, world), moves_of(self.game)
        leaving = [] if node is None else [move for move, to in zip(moves, after[node], strict=True) if to // 4 != node // 4]
        return self.random.choice(leaving or self.moves)


def random_stretch(game: ir.Game, recipes: Sequence[Recipe], goal: Goal | None, ran: Counter[Place], steps: int, random: Random) -> Stretch:
    """Returns what the agents do from a state on, for so many steps at most."""
    count = len(game.agents.actions)
    moves = ordinary(game)
    special = [a for a in range(count) if a not in moves]
    habits = [random.choice((special if special and random.random() < HABIT else None) or range(count)) for _ in range(game.agents.number)]
    return Stretch(game, random, steps, habits, moves, recipes, ran, goal, quiet=goal is not None and random.random() < QUIET)

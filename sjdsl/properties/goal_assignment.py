"""Assigns agents to a goal: who goes to which cell and takes which action, so that a chosen statement runs."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from random import Random

import numpy as np

from sjdsl.compiler import ir
from sjdsl.interpreter.board import Board, board_of
from sjdsl.interpreter.bodies import where_is
from sjdsl.interpreter.state import Cell, Mover, Value, World
from sjdsl.properties.preconditions import Goal, Precondition, Role, choose_precondition, place_of, roles_towards
from sjdsl.properties.reachability import can_go, closed_to, moves_until, node_of, others_of, stands
from sjdsl.properties.shortest_paths import FAR
from sjdsl.properties.statements import StatementId
from sjdsl.runtime.actions import STEPS, TURNS

AT_ONCE = 0.9  # how often agents with goals wait for each other, where a statement is to run for several of them
TOGETHER = 0.6  # how often otherwise
OTHER = 0.1  # how often one of several agents has another goal than the first
MORE = (0, 0, 1, 1, 2)  # how many agents more than a statement needs take part in it
SAME = 0.7  # how often several agents go to the same cell
NEAREST = 0.7  # how often an agent stands where it arrives first
FITTING = 0.9  # how often a cell is chosen for which the conditions of the statement hold
STILL = 0.5  # how often an agent that needs no particular cell acts where it is
MOVES = {*STEPS, *TURNS, "stay"}


@dataclass
class AgentGoal:
    """Where an agent goes: to stand on `stand`, or anywhere, with `target` in a shape, or on it. Which action it takes then, and how often.

    mover: the one that is on `target`, which is where it is now.
    """

    board: Board
    target: Cell
    shape: str | None
    stand: Cell | None
    action: int
    times: int
    mover: Mover | None = None

    def follow(self, world: World) -> None:
        """Goes after the mover, to stand anywhere, if it is elsewhere now; to where it was if it is away."""
        cell = None if self.mover is None else where_is(self.mover, world)
        if cell is not None and cell != self.target:
            self.target, self.stand = cell, None

    @property
    def distance(self) -> np.ndarray:
        """Moves from each node, see `reachability.moves_until`."""
        return moves_until(self.board, self.target, self.shape, self.stand)

    def distance_around(self, others: frozenset[Cell]) -> np.ndarray:
        """Returns the same for an agent that goes around some cells."""
        return moves_until(self.board, self.target, self.shape, self.stand, others)


@dataclass
class Assignment:
    """The goals of some agents. together: they wait for each other; longest: moves that the last of them takes to arrive."""

    agent_goals: dict[int, AgentGoal] = field(default_factory=dict)
    together: bool = False
    longest: int = 0


def ordinary(game: ir.Game) -> list[int]:
    """Returns the actions that are moves, or `stay`."""
    return [a for a, name in enumerate(game.agents.actions) if name in MOVES]


def assign_goals(
    game: ir.Game, goal: Goal, preconditions: Sequence[Precondition], ran: Counter[StatementId], world: World, random: Random
) -> Assignment:
    """Assigns goals: one to an agent for each role in the statement, or in those that achieve what it lacks; at times more agents join."""
    roles = roles_towards(goal, preconditions, game, world, random)
    for _ in range(random.choice(MORE)):
        roles.append(random.choice(roles) if random.random() > OTHER else Role(choose_precondition(preconditions, ran, random), ""))
    assigner = GoalAssigner(game, world, random)
    filled = assigner.filled(roles)
    at_last = any(role.precondition is preconditions[goal.precondition] or role.precondition.joins == name for _, name, role in filled)
    together = len(filled) > 1 and at_last and random.random() < (TOGETHER if goal.many == 1 else AT_ONCE)
    agent_goals = {agent: agent_goal for agent, name, role in filled if (agent_goal := assigner.agent_goal(agent, name, role)) is not None}
    moves = [agent_goal.distance[node] for agent, agent_goal in agent_goals.items() if (node := assigner.node(agent)) is not None]
    return Assignment(agent_goals, together, max((int(number) for number in moves if number < FAR), default=0))


@dataclass
class GoalAssigner:
    """What is assigned in one state. cast: who has which role; shared: cells and movers that several agents share; taken: where others will stand."""

    game: ir.Game
    world: World
    random: Random
    cast: dict[str, int] = field(default_factory=dict)
    shared: dict[str, Value] = field(default_factory=dict)
    taken: set[Cell] = field(default_factory=set)

    def node(self, agent: int) -> int | None:
        """Returns the node of an agent, see `reachability.node_of`."""
        return node_of(agent, self.world, board_of(self.game))

    def filled(self, roles: Sequence[Role]) -> list[tuple[int, str, Role]]:
        """Returns an agent for each role, as long as there are any, and its variable there; a fitting agent if there is one."""
        free = [agent for agent, cell in enumerate(self.world.position) if cell is not None]
        found: list[tuple[int, str, Role]] = []
        for role in roles[: len(free)]:
            precondition = role.precondition
            if role.rather and not set(role.rather) & set(free) and self.random.random() < AT_ONCE:
                continue  # it would only stand where another has to
            name = role.name if role.name in precondition.agents else self.random.choice(precondition.agents or ("",))
            fitting = [agent for agent in role.rather if agent in free] or precondition.fitting_agents(name, self.game, self.world)
            agent = self.random.choice([agent for agent in fitting if agent in free] or free)
            free.remove(agent)
            self.cast.setdefault(name, agent)
            found.append((agent, name, role))
        return found

    def agent_goal(self, agent: int, name: str, role: Role) -> AgentGoal | None:
        """Returns where an agent has to be for its role in a statement and which action it takes there; None if there is no such cell."""
        random, board, precondition = self.random, board_of(self.game), role.precondition
        action, times = random.choice(precondition.actions.get(name) or ordinary(self.game)), random.randint(1, 2)
        shape: str | None = None
        target: Value = None
        reaching = [(shape, member) for anchor, shape, member in precondition.reaches if anchor == name]
        if reaching:
            shape, member = random.choice(reaching)
            target = self._target(role, member, name, agent, shape)
        elif name in precondition.on or precondition.cells:
            standing = [cell for cell, kinds in precondition.cells.items() if kinds == precondition.on.get(name)]
            target = self._target(role, random.choice(standing or list(precondition.cells) or [""]), name, agent, None)
        cell = None if target is None else place_of(target, self.world)
        if cell is None:  # it only needs to act: where it is, or anywhere
            shape, cell = None, self.world.position[agent] if random.random() < STILL else random.choice(tuple(board.kind_of))
        mover = target if isinstance(target, Mover) else None
        return None if cell is None else AgentGoal(board, cell, shape, self._stand(agent, cell, shape), action, times, mover)

    def _stand(self, agent: int, target: Cell, shape: str | None) -> Cell | None:
        """Returns where an agent is to stand, apart from the others; None for anywhere, if there is no such cell."""
        board, node = board_of(self.game), self.node(agent)
        room = self._room(agent, target, shape)
        if not room:
            return None
        stand = self.random.choice(room)
        if node is not None and self.random.random() < NEAREST:
            stand = min(room, key=lambda cell: moves_until(board, target, shape, cell)[node])
        self.taken.add(stand)
        return stand

    def _room(self, agent: int, target: Cell, shape: str | None) -> list[Cell]:
        """Returns a cell where an agent can go and stand for a target, apart from the others: as all stand now, if there is one."""
        board, node = board_of(self.game), self.node(agent)
        free = [stand for stand in stands(board, target, shape) if stand not in self.taken]
        closed = closed_to(agent, self.world, board)
        for around in dict.fromkeys((closed | others_of(agent, self.world), closed, frozenset[Cell]())):
            room = [stand for stand in free if can_go(node, board, target, shape, stand, around)]
            if room:
                return room
        return []

    def _target(self, role: Role, member: str, name: str, agent: int, shape: str | None) -> Cell | Mover | None:
        """Returns the cell that an agent has to be on, or reach: of the agent that has that role, or a fitting one; or the mover it reaches."""
        random, precondition = self.random, role.precondition
        if member not in precondition.cells and member not in precondition.movers:
            others = [cell for other, cell in enumerate(self.world.position) if cell is not None and other != agent]
            known = self.world.position[self.cast[member]] if member in self.cast and self.cast[member] != agent else None
            return known or (random.choice(others) if others else None)
        fitting = precondition.fitting_members(member, self.game, self.world, {name: agent}, role.bound)
        places = {one: place_of(one, self.world) for one in fitting}
        fitting = [one for one, cell in places.items() if cell is not None and self._room(agent, cell, shape)] or fitting
        if self.shared.get(member) not in fitting or random.random() >= SAME:
            every = precondition.values(member, self.game, self.world, None)
            if not every:
                return None
            self.shared[member] = random.choice(fitting if fitting and random.random() < FITTING else every)
        found: Cell | Mover = self.shared[member]
        return found

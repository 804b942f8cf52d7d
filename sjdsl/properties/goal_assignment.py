"""Who is sent where, to do what, so that a sentence takes place."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from random import Random

import numpy as np

from sjdsl.compiler import ir
from sjdsl.interpreter.board import Board, board_of, cells_of
from sjdsl.interpreter.state import Cell, World
from sjdsl.properties.preconditions import Goal, Part, Recipe, choose_recipe, parts_towards
from sjdsl.properties.reachability import can_go, closed_to, moves_until, node_of, others_of, stands
from sjdsl.properties.shortest_paths import FAR, STEPS, TURNS
from sjdsl.properties.statements import Place

AT_ONCE = 0.9  # how often those who have errands wait for each other, where a sentence is to take place for several of them
TOGETHER = 0.6  # how often otherwise
OTHER = 0.1  # how often one of several has another errand than the first
MORE = (0, 0, 1, 1, 2)  # how many more than a sentence speaks of take part in it
SAME = 0.7  # how often several go to the same cell
NEAREST = 0.7  # how often one stands where it gets to first
FITTING = 0.9  # how often a cell is one for which the sentence's conditions hold
STILL = 0.5  # how often one that needs no place acts where it is
MOVES = {*STEPS, *TURNS, "stay"}


@dataclass
class Errand:
    """Where an agent goes: to stand on `stand`, or anywhere, with `target` in a shape, or there itself. What it does then, and for how many steps."""

    board: Board
    target: Cell
    shape: str | None
    stand: Cell | None
    action: int
    times: int

    @property
    def distance(self) -> np.ndarray:
        """Moves from each node, see `reachability.moves_until`."""
        return moves_until(self.board, self.target, self.shape, self.stand)

    def distance_around(self, others: frozenset[Cell]) -> np.ndarray:
        """Returns the same for one who goes around some cells."""
        return moves_until(self.board, self.target, self.shape, self.stand, others)


@dataclass
class Sent:
    """The errands of some agents. together: they wait for each other; longest: moves that the last of them takes to get there."""

    errands: dict[int, Errand] = field(default_factory=dict)
    together: bool = False
    longest: int = 0


def ordinary(game: ir.Game) -> list[int]:
    """Returns the actions that are moves, or `stay`."""
    return [a for a, name in enumerate(game.agents.actions) if name in MOVES]


def send_out(game: ir.Game, goal: Goal, recipes: Sequence[Recipe], ran: Counter[Place], world: World, random: Random) -> Sent:
    """Gives agents errands for a goal: one for each agent of the sentence, or of what it lacks; now and then others have the same."""
    parts = parts_towards(goal, recipes, game, world, random)
    for _ in range(random.choice(MORE)):
        parts.append(random.choice(parts) if random.random() > OTHER else Part(choose_recipe(recipes, ran, random), ""))
    sending = Sending(game, world, random)
    jobs = sending.jobs(parts)
    at_last = any(part.recipe is recipes[goal.recipe] or part.recipe.joins == name for _, name, part in jobs)
    together = len(jobs) > 1 and at_last and random.random() < (TOGETHER if goal.many == 1 else AT_ONCE)
    errands = {agent: errand for agent, name, part in jobs if (errand := sending.errand(agent, name, part)) is not None}
    ways = [errand.distance[node] for agent, errand in errands.items() if (node := sending.node(agent)) is not None]
    return Sent(errands, together, max((int(way) for way in ways if way < FAR), default=0))


@dataclass
class Sending:
    """What is handed out in one state. cast: who has which part; shared: the cells on which several agree; taken: where others will stand."""

    game: ir.Game
    world: World
    random: Random
    cast: dict[str, int] = field(default_factory=dict)
    shared: dict[str, Cell] = field(default_factory=dict)
    taken: set[Cell] = field(default_factory=set)

    def node(self, agent: int) -> int | None:
        """Returns where an agent is, see `reach.node_of`."""
        return node_of(agent, self.world, board_of(self.game))

    def jobs(self, parts: Sequence[Part]) -> list[tuple[int, str, Part]]:
        """Returns an agent for each part, as long as there are any: one that fits, if one does; and the name it has there."""
        free = [agent for agent, place in enumerate(self.world.position) if place is not None]
        found: list[tuple[int, str, Part]] = []
        for part in parts[: len(free)]:
            recipe = part.recipe
            if part.rather and not set(part.rather) & set(free) and self.random.random() < AT_ONCE:
                continue  # it would only stand where another has to
            name = part.name if part.name in recipe.agents else self.random.choice(recipe.agents or ("",))
            fitting = [agent for agent in part.rather if agent in free] or recipe.fitting_agents(name, self.game, self.world)
            agent = self.random.choice([agent for agent in fitting if agent in free] or free)
            free.remove(agent)
            self.cast.setdefault(name, agent)
            found.append((agent, name, part))
        return found

    def errand(self, agent: int, name: str, part: Part) -> Errand | None:
        """Returns where an agent has to be for its part in a sentence, and what it does there; None if there is no such place."""
        random, board, recipe = self.random, board_of(self.game), part.recipe
        action, times = random.choice(recipe.actions.get(name) or ordinary(self.game)), random.randint(1, 2)
        shape: str | None = None
        target: Cell | None = None
        reaching = [(shape, member) for anchor, shape, member in recipe.reaches if anchor == name]
        if reaching:
            shape, member = random.choice(reaching)
            target = self._target(part, member, name, agent, shape)
        elif name in recipe.on or recipe.cells:
            standing = [cell for cell, kinds in recipe.cells.items() if kinds == recipe.on.get(name)]
            target = self._target(part, random.choice(standing or list(recipe.cells) or [""]), name, agent, None)
        if target is None:  # all it takes is an action: where it is, or anywhere
            shape, target = None, self.world.position[agent] if random.random() < STILL else random.choice(tuple(board.kind_of))
        return None if target is None else Errand(board, target, shape, self._stand(agent, target, shape), action, times)

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
        """Returns where an agent can get to and stand for a target, apart from the others: as all stand now, if there is such a cell."""
        board, node = board_of(self.game), self.node(agent)
        free = [stand for stand in stands(board, target, shape) if stand not in self.taken]
        closed = closed_to(agent, self.world, board)
        for around in dict.fromkeys((closed | others_of(agent, self.world), closed, frozenset[Cell]())):
            room = [stand for stand in free if can_go(node, board, target, shape, stand, around)]
            if room:
                return room
        return []

    def _target(self, part: Part, member: str, name: str, agent: int, shape: str | None) -> Cell | None:
        """Returns the cell that one has to be on, or reach: of the agent that has that part, or one that fits."""
        random, board = self.random, board_of(self.game)
        if member not in part.recipe.cells:
            others = [place for other, place in enumerate(self.world.position) if place is not None and other != agent]
            known = self.world.position[self.cast[member]] if member in self.cast and self.cast[member] != agent else None
            return known or (random.choice(others) if others else None)
        fitting = part.recipe.fitting_cells(member, self.game, self.world, {name: agent}, part.bound)
        fitting = [cell for cell in fitting if self._room(agent, cell, shape)] or fitting
        if self.shared.get(member) in fitting and random.random() < SAME:
            return self.shared[member]
        of_kind = cells_of(board, part.recipe.cells[member])
        if not of_kind:
            return None
        self.shared[member] = random.choice(fitting if fitting and random.random() < FITTING else of_kind)
        return self.shared[member]

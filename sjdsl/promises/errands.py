"""What agents do in a stretch of a course: habits, or errands: to go where a sentence can take place and act there, alone or together."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from random import Random

import numpy as np

from sjdsl.compiler import ir
from sjdsl.interpreter.board import Board, board_of, cells_of
from sjdsl.interpreter.shapes import cell_at
from sjdsl.interpreter.state import Cell, World
from sjdsl.promises.recipes import Part, Recipe, choose_recipe, parts_towards
from sjdsl.promises.sentences import Place
from sjdsl.promises.ways import FAR, STEPS, TURNS, moves_of, moves_to

HABIT = 0.5  # how often an agent does what it always does
TOGETHER = 0.6  # how often those who have errands wait for each other
ASTRAY = 0.1  # how often one on the way takes another move, so that two who meet in a passage part again
OTHER = 0.25  # how often one of several has another errand than the first
WAITS = 7  # steps for which those who wait for each other do so
MORE = (0, 0, 1, 1, 2)  # how many more than a sentence speaks of take part in it
SAME = 0.7  # how often several go to the same cell
FITTING = 0.9  # how often a cell is one for which the sentence's conditions hold
MOVES = {*STEPS, *TURNS, "stay"}


@dataclass
class Errand:
    """Where an agent goes, as moves from each node (`ways.moves_to`), what it does there, and for how many steps."""

    distance: np.ndarray
    action: int
    times: int


@dataclass
class Stretch:
    """Drives the agents for a number of steps.

    habits: the action each agent often takes. focus: the sentence for which agents are sent out, again and again until it is over.
    errands: of some agents. together: they wait until all have arrived, or until step `patience` of the stretch.
    """

    game: ir.Game
    random: Random
    steps: int
    habits: Sequence[int]
    recipes: Sequence[Recipe]
    ran: Counter[Place]
    focus: Recipe | None = None
    errands: dict[int, Errand] = field(default_factory=dict)
    together: bool = False
    patience: int = 0
    _taken: int = 0

    def __call__(self, world: World, number: int) -> tuple[int, ...] | None:
        """Returns an action for each agent; None at the end."""
        del number
        if self._taken >= self.steps:
            return None
        if self.focus is not None and not any(e.times for e in self.errands.values()):
            self.errands = {}
            _send_out(self, self.focus, world)
        self._taken += 1
        arrived = {agent: self._has_arrived(agent, world) for agent in self.errands}
        now = not self.together or all(arrived.values()) or self._taken > self.patience
        if self.together and now:
            self.patience = 0
        return tuple(
            self._on_errand(agent, world, arrived[agent], now) if agent in self.errands else self._by_habit(agent)
            for agent in range(self.game.agents.number)
        )

    def _by_habit(self, agent: int) -> int:
        if self.random.random() < HABIT:
            return self.habits[agent]
        return self.random.randrange(len(self.game.agents.actions))

    def _node(self, agent: int, world: World) -> int | None:
        place = world.position[agent]
        return None if place is None else (place.row * len(self.game.rows[0]) + place.col) * 4 + world.heading[agent]

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
        return moves[int(np.argmin(errand.distance[after[node]]))]


def random_stretch(
    game: ir.Game, recipes: Sequence[Recipe], focus: Recipe | None, ran: Counter[Place], steps: int, random: Random
) -> Stretch:
    """Returns what the agents do from a state on, for so many steps at most."""
    count = len(game.agents.actions)
    special = [a for a, name in enumerate(game.agents.actions) if name not in MOVES]
    habits = [random.choice((special if special and random.random() < HABIT else None) or range(count)) for _ in range(game.agents.number)]
    return Stretch(game, random, steps, habits, recipes, ran, focus)


def _send_out(stretch: Stretch, focus: Recipe, world: World) -> None:
    """Gives agents errands for a sentence to take place: one for each agent it speaks of, and now and then others with the same."""
    game, random, recipes, ran = stretch.game, stretch.random, stretch.recipes, stretch.ran
    free = [agent for agent, place in enumerate(world.position) if place is not None]
    cast: dict[str, int] = {}
    jobs: list[tuple[int, str, Recipe]] = []
    parts = parts_towards(focus, recipes, game, world, random)
    for _ in range(random.choice(MORE)):
        parts.append(random.choice(parts) if random.random() > OTHER else Part(choose_recipe(recipes, ran, random), ""))
    for part in parts:
        recipe = part.recipe
        name = part.name if part.name in recipe.agents else random.choice(recipe.agents or ("",))
        fitting = [agent for agent in part.rather if agent in free] or recipe.fitting_agents(name, game, world)
        fitting = [agent for agent in fitting if agent in free] or free
        if not fitting:
            break
        agent = random.choice(fitting)
        free.remove(agent)
        cast.setdefault(name, agent)
        jobs.append((agent, name, recipe))
    stretch.together = len(jobs) > 1 and random.random() < TOGETHER
    stretch.patience = stretch._taken + WAITS
    shared: dict[str, Cell] = {}
    for agent, name, recipe in jobs:
        errand = _errand(recipe, name, agent, stretch, world, cast, shared)
        if errand is not None:
            stretch.errands[agent] = errand


def _errand(
    recipe: Recipe, name: str, agent: int, stretch: Stretch, world: World, cast: Mapping[str, int], shared: dict[str, Cell]
) -> Errand | None:
    """Returns where an agent has to be for its part in a sentence, and what it does there; None if it cannot move.

    cast: who has which part; shared: the cells on which several agree.
    """
    game, random = stretch.game, stretch.random
    moves, after = moves_of(game)
    if not moves:
        return None
    ordinary = [a for a, known in enumerate(game.agents.actions) if known in MOVES]
    action = random.choice(recipe.actions.get(name) or ordinary)
    goals: Sequence[int] = ()
    reaching = [(shape, member) for anchor, shape, member in recipe.reaches if anchor == name]
    if reaching:
        shape, member = random.choice(reaching)
        target = _target(recipe, member, {name: agent}, stretch, world, cast, shared)
        goals = _nodes_around(target, shape, board_of(game)) if target is not None else ()
    elif name in recipe.on or recipe.cells:
        standing = [cell for cell, kinds in recipe.cells.items() if kinds == recipe.on.get(name)]
        member = random.choice(standing or list(recipe.cells) or [""])
        target = _target(recipe, member, {name: agent}, stretch, world, cast, shared)
        goals = _nodes_on(target, game) if target is not None else ()
    if not goals:  # all it takes is an action: where it is, or anywhere
        place = world.position[agent] if random.random() < HABIT else random.choice(tuple(board_of(game).kind_of))
        goals = _nodes_on(place, game) if place is not None else ()
    return Errand(moves_to(goals, after), action, random.randint(1, 2)) if goals else None


def _target(
    recipe: Recipe, member: str, agent: Mapping[str, int], stretch: Stretch, world: World, cast: Mapping[str, int], shared: dict[str, Cell]
) -> Cell | None:
    """Returns the cell that one has to be on, or reach: of the agent that has that part, or one that fits."""
    random, game = stretch.random, stretch.game
    if member not in recipe.cells:
        others = [place for other, place in enumerate(world.position) if place is not None and other not in agent.values()]
        known = world.position[cast[member]] if member in cast and cast[member] not in agent.values() else None
        return known or (random.choice(others) if others else None)
    fitting = recipe.fitting_cells(member, game, world, agent)
    if shared.get(member) in fitting and random.random() < SAME:
        return shared[member]
    of_kind = cells_of(board_of(game), recipe.cells[member])
    if not of_kind:
        return None
    shared[member] = random.choice(fitting if fitting and random.random() < FITTING else of_kind)
    return shared[member]


def _nodes_on(cell: Cell, game: ir.Game) -> list[int]:
    number = cell.row * len(game.rows[0]) + cell.col
    return [number * 4 + heading for heading in range(4)]


def _nodes_around(target: Cell, shape: str, board: Board) -> list[int]:
    """Returns the nodes from which a shape, nothing in between, reaches a cell."""
    declared, found = board.shapes[shape], []
    for lane in declared.lanes:
        for ahead, right in lane:
            for heading in range(4):
                turned = heading if declared.directed else 0
                origin = cell_at(target, turned, -ahead, -right)
                if origin in board.kind_of and origin != target:
                    found.append((origin.row * len(board.game.rows[0]) + origin.col) * 4 + heading)
    return found

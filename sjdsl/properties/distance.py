"""How far a state is from a sentence taking place: by how much its conditions fail, and what the sentences lack that could make them true.

A sum over conditions, each brought about on its own (h_add of Bonet and Geffner 2001, "Planning as heuristic search"), with the branch
distances of search-based testing for numbers (Tracey et al. 1998): one who needs three of something is farther than one who needs one.
"""

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product

from sjdsl.compiler import ir
from sjdsl.interpreter.board import board_of, cells_of
from sjdsl.interpreter.evaluate import evaluate
from sjdsl.interpreter.instance import Instance
from sjdsl.interpreter.state import Cell, Value, World
from sjdsl.properties.effects import reads
from sjdsl.properties.preconditions import Bound, Recipe, can_make, is_timed
from sjdsl.properties.reachability import can_go, moves_until, node_of, stands
from sjdsl.properties.shortest_paths import FAR

FAILED = 1.0  # distance of a condition that is no comparison of numbers
MOST = 8.0  # above it, the distance of numbers grows with the logarithm
WAITING = 0.25  # a step of waiting, beside a sentence that must take place
MOVE = 0.02  # a move, likewise: of two ways to do something the shorter one
NEAREST = 3  # cells that are looked at further: those of which least is missing
ROUNDS = 8  # of sums; no chain of sentences that matters is longer


@dataclass(frozen=True)
class Lack:
    """A condition that fails in one choice of its variables: by how much, and which sentences, of whom, could make it hold."""

    gap: float
    writers: tuple[tuple[int, Bound], ...]
    timed: bool
    gathers: bool = False  # agents have to be brought into a set: as many as the sentence is to take place for


@dataclass
class Needs:
    """What a sentence lacks: for each of its variables, for each choice, the way there and the lacks; and the lacks that are the same for all."""

    choices: list[list[tuple[float, list[Lack]]]] = field(default_factory=list)
    everywhere: list[Lack] = field(default_factory=list)
    agents: int = 0  # so many of `choices`, the first ones, are of agents
    room: float = math.inf  # for so many agents there is room where one has to stand


class Chains:
    """Which sentences could make which condition hold, on any map."""

    def __init__(self, recipes: Sequence[Recipe]):
        self.recipes = recipes
        self._known: dict[int, tuple[ir.Expr, tuple[int, ...], frozenset[str], bool]] = {}

    def of(self, test: ir.Expr, game: ir.Game) -> tuple[tuple[int, ...], frozenset[str], bool]:
        """Returns the sentences, by their place; the variables whose fields the condition reads; and whether waiting may do as well."""
        if id(test) not in self._known:
            read = set(reads(test))
            writers = tuple(i for i, r in enumerate(self.recipes) if r.writes & read and can_make(r, test))
            owners = frozenset(n.owner.name for n in ir.walk(test) if isinstance(n, ir.FieldRead) and isinstance(n.owner, ir.Member))
            self._known[id(test)] = (test, writers, owners, is_timed(test, game))
        return self._known[id(test)][1:]


class Distances:
    """The distances of one state from sentences, by their place among the recipes."""

    def __init__(self, chains: Chains, game: ir.Game, world: World):
        self._chains, self._recipes, self._game, self._world = chains, chains.recipes, game, world
        self._here = Instance(board_of(game), world)
        self._agents = [agent for agent, place in enumerate(world.position) if place is not None]
        self._needs: dict[tuple[int, Bound], Needs] = {}
        self._far: dict[tuple[int, Bound], float] = {}

    def of(self, recipe: int, many: int = 1, bound: Bound = None) -> float:
        """Returns how far the state is from a sentence taking place for so many agents (of each kind it speaks of); inf: no way is seen."""
        self._settle((recipe, bound))
        return self._sum(self._needs[recipe, bound], many)

    def _settle(self, node: tuple[int, Bound]) -> None:
        """Works out what a sentence lacks, and those that could help it, and so on; then their distances."""
        waiting = [node]
        while waiting:
            at = waiting.pop()
            if at in self._needs:
                continue
            needs = self._needs[at] = self._look(self._recipes[at[0]], at[1])
            self._far[at] = math.inf
            waiting += [
                w for group in (*(lacks for c in needs.choices for _, lacks in c), needs.everywhere) for lack in group for w in lack.writers
            ]
        for _ in range(ROUNDS):
            now = {at: self._sum(needs, 1) for at, needs in self._needs.items()}
            if now == self._far:
                break
            self._far = now

    def _sum(self, needs: Needs, many: int) -> float:
        if many > needs.room:
            return math.inf
        total = sum(self._price(lack, many) for lack in needs.everywhere)
        for i, choices in enumerate(needs.choices):
            prices = sorted(way + sum(self._price(lack, many) for lack in lacks) for way, lacks in choices)
            wanted = many if i < needs.agents else 1
            total += sum(prices[:wanted]) if len(prices) >= wanted else math.inf
        return total

    def _price(self, lack: Lack, many: int) -> float:
        waiting = WAITING * lack.gap if lack.timed else math.inf
        if lack.gathers and many > 1:
            return min([waiting, *(lack.gap * (1 + self._sum(self._needs[writer], many)) for writer in lack.writers)])
        return min([waiting, *(lack.gap * (1 + self._far[writer]) for writer in lack.writers)])

    def _look(self, recipe: Recipe, bound: Bound) -> Needs:
        needs = Needs()
        names = [*recipe.agents, *recipe.cells]
        tests: dict[str, list[tuple[frozenset[str], ir.Expr]]] = {name: [] for name in names}
        for named, test in recipe.tests:
            owner = next((name for name in names if name in named), None)
            if owner is None:
                lack = self._lack(recipe, test, {})
                needs.everywhere += [lack] if lack is not None else []
            else:
                tests[owner].append((named, test))
        for name in names:
            values = self._values(recipe, name, bound)
            lacks = [[lack for named, test in tests[name] if (lack := self._least(recipe, named, test, name, v, bound))] for v in values]
            ways = [
                self._way(recipe, name, v, bound) + self._way_to_others(recipe, name, v, bound) if name in recipe.agents else 0.0
                for v in values
            ]
            found = list(zip(ways, lacks, strict=True))
            if name in recipe.cells:
                found = sorted(found, key=lambda choice: sum(lack.gap for lack in choice[1]))[:NEAREST]
            needs.choices.append(found)
            needs.agents += name in recipe.agents
        needs.room = min((self._room(recipe, name, bound) for name in recipe.agents), default=math.inf)
        return needs

    def _way(self, recipe: Recipe, name: str, agent: Value, bound: Bound) -> float:
        """Returns how far an agent has to go until it reaches, or stands on, cells of which a sentence speaks; inf: there is no way."""
        wanted = self._wanted(recipe, name)
        board, node = board_of(self._game), node_of(agent, self._world, board_of(self._game))
        total = 0.0
        for shape, member in wanted:
            moves = min((moves_until(board, cell, shape)[node] for cell in self._values(recipe, member, bound)), default=FAR)
            total += math.inf if moves >= FAR else MOVE * float(moves)
        return total

    def _way_to_others(self, recipe: Recipe, name: str, agent: Value, bound: Bound) -> float:
        """Returns how far an agent has to go that has to be gathered with others; inf: there is no way to any cell that is as good as the best."""
        total = 0.0
        for _, gathered in (pair for pair in recipe.gathers if pair[0] == name):
            cells = recipe.cells_for(gathered, self._game, self._world, bound)
            joined = [w for w in self._recipes if w.joins is not None and w.writes & set(reads(gathered))]
            joining = [
                (w, w.joins, o) for w in joined if w.joins for o in ([(w.owner, c) for c in cells] if w.owner in w.cells else [None])
            ]
            ways = [self._way(w, joins, agent, one) for w, joins, one in joining]
            total += min(ways, default=math.inf if joined else 0.0)
        return total

    def _wanted(self, recipe: Recipe, name: str) -> list[tuple[str | None, str]]:
        """Returns the cells that an agent must have in a shape, or, for None, be on."""
        reached = [(shape, member) for anchor, shape, member in recipe.reaches if anchor == name and member in recipe.cells]
        return [*reached, *((None, member) for member, kinds in recipe.cells.items() if kinds == recipe.on.get(name))]

    def _room(self, recipe: Recipe, name: str, bound: Bound) -> float:
        """Returns how many agents can stand at once where one has to stand, and can get there; inf if it matters not where."""
        board, nodes = board_of(self._game), [node_of(a, self._world, board_of(self._game)) for a in self._agents]
        found: set[Cell] = set()
        wanted = self._wanted(recipe, name)
        for shape, member in wanted:
            at = [stand for cell in self._values(recipe, member, bound) for stand in stands(board, cell, shape)]
            found |= {stand for stand in at if any(can_go(node, board, stand) for node in nodes)}
        return len(found) if wanted else math.inf

    def _values(self, recipe: Recipe, name: str, bound: Bound) -> Sequence[Value]:
        if bound is not None and bound[0] == name:
            return [bound[1]]
        return cells_of(board_of(self._game), recipe.cells[name]) if name in recipe.cells else self._agents

    def _least(self, recipe: Recipe, named: frozenset[str], test: ir.Expr, name: str, value: Value, bound: Bound) -> Lack | None:
        """Returns what a condition lacks with one variable chosen and the others at best; None if it holds, or nothing is said of it."""
        others = [n for n in named if n != name]
        if len(others) > 1 or any(n not in recipe.cells and n not in recipe.agents for n in others):
            return None
        best: Lack | None = None
        for rest in product(*(self._values(recipe, n, bound) for n in others)):
            lack = self._lack(recipe, test, {name: value, **dict(zip(others, rest, strict=True))})
            if lack is None:
                return None
            best = lack if best is None or lack.gap < best.gap else best
        return best or Lack(math.inf, (), False)

    def _lack(self, recipe: Recipe, test: ir.Expr, names: Mapping[str, Value]) -> Lack | None:
        try:
            gap = shortfall(test, self._here.only(names))
        except AssertionError:  # read of nobody: another condition protects
            gap = FAILED
        if not gap:
            return None
        writers, owners, timed = self._chains.of(test, self._game)
        values = {names[owner] for owner in owners if owner in names}
        gathers = any(test is gathered for _, gathered in recipe.gathers)
        return Lack(gap, tuple((i, _whose(self._recipes[i], values)) for i in writers), timed, gathers)


def _whose(writer: Recipe, values: Collection[Value]) -> Bound:
    """Returns of whom, or of which cell, a sentence has to write, given those of whom a condition reads."""
    if writer.owner is None:
        return None
    fitting = [v for v in values if isinstance(v, int) == (writer.owner in writer.agents)]
    return (writer.owner, fitting[0]) if len(fitting) == 1 else None


def shortfall(test: ir.Expr, here: Instance) -> float:
    """Returns 0 if a condition holds, and otherwise by how much it fails: numbers by their difference, anything else by 1."""
    match test:
        case ir.Named():
            return shortfall(test.value, here)
        case ir.Logic():
            each = [shortfall(arg, here) for arg in test.args] if not evaluate(test, here) else [0.0]
            return sum(each) if test.fn == "and" else min(each)
        case ir.Compare() if not evaluate(test, here) and test.fn != "!=":
            return _steps(evaluate(test.left, here), evaluate(test.right, here))
        case ir.InRange() if not evaluate(test, here):
            value = evaluate(test.value, here)
            return min(_steps(value, evaluate(test.low, here)), _steps(value, evaluate(test.high, here)))
        case _:
            return 0.0 if evaluate(test, here) else FAILED


def _steps(left: Value, right: Value) -> float:
    """Returns how far apart two numbers are; at least 1, as a condition on them fails."""
    apart = float(abs(left - right)) if isinstance(left, int) and isinstance(right, int) else min(MOST, abs(float(left) - float(right)))
    return max(FAILED, apart if apart <= MOST else MOST + math.log2(apart / MOST))

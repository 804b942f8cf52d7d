"""How far a state is from a sentence taking place: by how much its conditions fail, and what the sentences lack that could make them true.

A sum over conditions, each brought about on its own (h_add of Bonet and Geffner 2001, "Planning as heuristic search"), with the branch
distances of search-based testing for numbers (Tracey et al. 1998): one who needs three of something is farther than one who needs one.
"""

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import combinations, product

from sjdsl.compiler import ir
from sjdsl.interpreter.board import board_of, cells_of
from sjdsl.interpreter.evaluate import evaluate
from sjdsl.interpreter.instance import Instance
from sjdsl.interpreter.state import Cell, Value, World
from sjdsl.properties.effects import reads
from sjdsl.properties.multiplicity import most
from sjdsl.properties.preconditions import Bound, Recipe, can_make, is_timed
from sjdsl.properties.reachability import can_go, closed_to, moves_until, node_of, others_of, stands
from sjdsl.properties.shortest_paths import FAR

FAILED = 1.0  # distance of a condition that is no comparison of numbers
MOST = 8.0  # above it, the distance of numbers grows with the logarithm
WAITING = 0.25  # a step of waiting, beside a sentence that must take place
MOVE = 0.02  # a move, likewise: of two ways to do something the shorter one
PAST_AGENTS = 0.3  # beside it, a way on which others stand
PAST_CLOSED = 1.0  # a way on which something has to be opened first
ABLE = 6  # agents of whom some are chosen who can stand apart: those of whom least is missing
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
    stands: list[list[frozenset[Cell] | None]] = field(default_factory=list)  # where they could stand for that; None: anywhere
    most: int = 1  # so often it can take place in one step
    each: list[int] = field(default_factory=list)  # likewise, for each member of a variable, in the order of `choices`


class Chains:
    """Which sentences could make which condition hold, on any map."""

    def __init__(self, recipes: Sequence[Recipe]):
        """Sentences that need the same, side by side in one block, count as the first of them, `first`: what they lack is looked for once."""
        self.recipes = recipes
        firsts: dict[tuple[object, ...], int] = {}
        self.first = [firsts.setdefault(_needs_of(recipe), i) for i, recipe in enumerate(recipes)]
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
        self._gaps: dict[tuple[object, ...], float] = {}
        self._shut: dict[int, frozenset[Cell]] = {}
        self._joins: dict[tuple[object, ...], list[tuple[Recipe, str, Bound]]] = {}

    def of(self, recipe: int, many: int = 1, bound: Bound = None) -> float:
        """Returns how far the state is from a sentence taking place for so many agents (of each kind it speaks of); inf: no way is seen."""
        node = (self._chains.first[recipe], bound)
        self._settle(node)
        return self._sum(self._needs[node], many)

    def _settle(self, node: tuple[int, Bound]) -> None:
        """Works out what a sentence lacks, and those that could help it, and so on, as far as that is not known; then their distances."""
        waiting, new = [node], dict[tuple[int, Bound], Needs]()
        while waiting:
            at = waiting.pop()
            if at in self._needs:
                continue
            needs = self._needs[at] = new[at] = self._look(self._recipes[at[0]], at[1])
            self._far[at] = math.inf
            waiting += [
                w for group in (*(lacks for c in needs.choices for _, lacks in c), needs.everywhere) for lack in group for w in lack.writers
            ]
        for _ in range(ROUNDS):
            now = {at: self._sum(needs, 1) for at, needs in new.items()}
            if all(self._far[at] == far for at, far in now.items()):
                break
            self._far.update(now)

    def _sum(self, needs: Needs, many: int) -> float:
        if many > needs.most:
            return math.inf
        total = sum(self._price(lack, many) for lack in needs.everywhere)
        for i, choices in enumerate(needs.choices):
            is_agent = i < needs.agents
            within = many if is_agent else min(many, needs.each[i])
            prices = [way + sum(self._price(lack, within) for lack in lacks) for way, lacks in choices]
            if is_agent and many > 1:
                total += cheapest(prices, needs.stands[i], min(many, len(self._agents)))
                continue
            wanted = -(-within // max(1, needs.each[i]))
            total += sum(sorted(prices)[:wanted]) if prices and len(prices) >= wanted else math.inf
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
            if name in recipe.agents:
                needs.stands.append([self._stands(recipe, name, v, bound) for v in values])
        needs.most = most(recipe.quantifiers, self._here.board)
        needs.each = [most(recipe.quantifiers, self._here.board, name) for name in names]
        return needs

    def _way(self, recipe: Recipe, name: str, agent: Value, bound: Bound) -> float:
        """Returns how far an agent has to go until it reaches, or stands on, cells of which a sentence speaks; inf: there is no way."""
        wanted = self._wanted(recipe, name)
        board, node = board_of(self._game), node_of(agent, self._world, board_of(self._game))
        total = 0.0
        for shape, member in wanted:
            cells, before = self._values(recipe, member, bound), total
            closed = self._closed(agent)
            total += math.inf
            for price, around in ((0.0, closed | others_of(agent, self._world)), (PAST_AGENTS, closed), (PAST_CLOSED, frozenset[Cell]())):
                moves = min((moves_until(board, cell, shape, None, around)[node] for cell in cells), default=FAR)
                if moves < FAR:
                    total = before + price + MOVE * float(moves)
                    break
        return total

    def _closed(self, agent: int) -> frozenset[Cell]:
        if agent not in self._shut:
            self._shut[agent] = closed_to(agent, self._world, self._here.board)
        return self._shut[agent]

    def _way_to_others(self, recipe: Recipe, name: str, agent: Value, bound: Bound) -> float:
        """Returns how far an agent has to go that has to be gathered with others; inf: there is no way to any cell that is as good as the best."""
        total = 0.0
        for _, gathered in (pair for pair in recipe.gathers if pair[0] == name):
            joining = self._joining(recipe, gathered, bound)
            ways = [self._way(w, joins, agent, one) for w, joins, one in joining]
            total += min(ways, default=0.0)
        return total

    def _joining(self, recipe: Recipe, gathered: ir.Expr, bound: Bound) -> list[tuple[Recipe, str, Bound]]:
        """Returns the sentences that bring agents into a set, each with who joins and whose set it is: of the cells for which it would do most."""
        key = (id(gathered), bound)
        if key not in self._joins:
            cells = recipe.cells_for(gathered, self._game, self._world, bound)
            joined = [w for w in self._recipes if w.joins is not None and w.writes & set(reads(gathered))]
            self._joins[key] = [
                (w, w.joins, o) for w in joined if w.joins for o in ([(w.owner, c) for c in cells] if w.owner in w.cells else [None])
            ]
        return self._joins[key]

    def _wanted(self, recipe: Recipe, name: str) -> list[tuple[str | None, str]]:
        """Returns the cells that an agent must have in a shape, or, for None, be on."""
        reached = [(shape, member) for anchor, shape, member in recipe.reaches if anchor == name and member in recipe.cells]
        return [*reached, *((None, member) for member, kinds in recipe.cells.items() if kinds == recipe.on.get(name))]

    def _stands(self, recipe: Recipe, name: str, agent: Value, bound: Bound) -> frozenset[Cell] | None:
        """Returns the cells on which an agent can stand for its part, or to be gathered for it, and to which it can get; None: anywhere."""
        board, node = board_of(self._game), node_of(agent, self._world, board_of(self._game))
        asked = [(recipe, name, bound)]
        for _, gathered in (pair for pair in recipe.gathers if pair[0] == name):
            asked += self._joining(recipe, gathered, bound)
        wanted = [(shape, cell) for r, n, b in asked for shape, member in self._wanted(r, n) for cell in self._values(r, member, b)]
        found = {(shape, cell, at) for shape, cell in wanted for at in stands(board, cell, shape)}
        return frozenset(at for shape, cell, at in found if can_go(node, board, cell, shape, at)) if wanted else None

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
        gap = self._gap(test, names)
        if not gap:
            return None
        writers, owners, timed = self._chains.of(test, self._game)
        values = {names[owner] for owner in owners if owner in names}
        gathers = any(test is gathered for _, gathered in recipe.gathers)
        first = self._chains.first
        return Lack(gap, tuple(dict.fromkeys((first[i], _whose(self._recipes[i], values)) for i in writers)), timed, gathers)

    def _gap(self, test: ir.Expr, names: Mapping[str, Value]) -> float:
        """Returns by how much a condition fails: worked out once, though many sentences stand under it."""
        key = (id(test), *names.items())
        if key not in self._gaps:
            try:
                self._gaps[key] = shortfall(test, self._here.only(names))
            except AssertionError:  # read of nobody: another condition protects
                self._gaps[key] = FAILED
        return self._gaps[key]


def _needs_of(recipe: Recipe) -> tuple[object, ...]:
    """Returns what tells a sentence from others in what it needs, whatever it does."""
    parts = (recipe.agents, tuple(recipe.cells.items()), tuple(recipe.on.items()), recipe.reaches)
    return (
        *parts,
        *map(id, recipe.quantifiers),
        *((name, id(test)) for name, test in recipe.gathers),
        *(id(test) for _, test in recipe.tests),
    )


def cheapest(prices: Sequence[float], places: Sequence[frozenset[Cell] | None], number: int) -> float:
    """Returns the least sum of the prices of so many who can all stand apart; inf if there are not so many. None: one stands anywhere."""
    able = sorted((price, i) for i, price in enumerate(prices) if price < math.inf)[:ABLE]
    groups = sorted((sum(price for price, _ in group), [i for _, i in group]) for group in combinations(able, number))
    return next((price for price, group in groups if _stand_apart([places[i] for i in group])), math.inf)


def _stand_apart(places: Sequence[frozenset[Cell] | None]) -> bool:
    """Returns whether each can have a cell of its own."""
    short = sorted((cells for cells in places if cells is not None and len(cells) < len(places)), key=len)  # others always find one
    return not short or any(_stand_apart([c - {cell} for c in short[1:]]) for cell in short[0])


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

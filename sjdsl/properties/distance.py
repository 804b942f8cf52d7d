"""Distance of a state from a statement running: the branch distances of its conditions, and of the statements that achieve them.

A sum over conditions, each achieved on its own (h_add of Bonet and Geffner 2001, "Planning as heuristic search"), with the branch
distances of search-based testing for numbers (Tracey et al. 1998): who needs three of something is farther away than who needs one.
"""

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import combinations, product

from sjdsl.compiler import ir
from sjdsl.interpreter.board import board_of
from sjdsl.interpreter.evaluate import evaluate
from sjdsl.interpreter.instance import Instance
from sjdsl.interpreter.state import Cell, Value, World
from sjdsl.properties.effects import reads
from sjdsl.properties.multiplicity import most
from sjdsl.properties.preconditions import Bound, Precondition, can_be, can_make, is_timed, place_of
from sjdsl.properties.reachability import can_go, closed_to, least_moves, node_of, others_of, stands
from sjdsl.properties.shortest_paths import FAR

FAILED = 1.0  # distance of a failing condition that compares no numbers
MOST = 8.0  # above it, the distance of numbers grows with the logarithm
WAITING = 0.25  # a step of waiting, where a statement that must run counts 1
MOVE = 0.02  # a move, likewise: the shorter of two ways to achieve something is better
PAST_AGENTS = 0.3  # likewise, a path on which other agents stand
PAST_CLOSED = 1.0  # likewise, a path that has to be opened first
ABLE = 6  # agents from whom those that can stand apart are chosen: those with the least distance
NEAREST = 3  # cells that are looked at further: those with the least distance
ROUNDS = 8  # of the fixed-point iteration; no chain of statements that matters is longer


@dataclass(frozen=True)
class UnmetCondition:
    """A condition that fails for one choice of its variables: its branch distance, and which statements could make it hold, for whom."""

    gap: float
    writers: tuple[tuple[int, Bound], ...]
    timed: bool
    gathers: bool = False  # agents have to join a set: as many as the statement is to run for


@dataclass
class Requirements:
    """What a statement lacks: for each value of each variable, the way there and the unmet conditions; and those without a variable."""

    choices: list[list[tuple[float, list[UnmetCondition]]]] = field(default_factory=list)
    everywhere: list[UnmetCondition] = field(default_factory=list)
    agents: int = 0  # the first so many of `choices` are of agents
    stands: list[list[frozenset[Cell] | None]] = field(default_factory=list)  # where they could stand for that; None: anywhere
    most: int = 1  # how often it can run in one step
    each: list[int] = field(default_factory=list)  # likewise, for each value of a variable, in the order of `choices`


class Achievers:
    """Which statements could make which condition hold (its achievers), on any map."""

    def __init__(self, preconditions: Sequence[Precondition]):
        """Groups statements of one block with equal needs under the first of them, `first`, so that what they lack is computed once."""
        self.preconditions = preconditions
        firsts: dict[tuple[object, ...], int] = {}
        self.first = [firsts.setdefault(_needs_of(precondition), i) for i, precondition in enumerate(preconditions)]
        self._known: dict[int, tuple[ir.Expr, tuple[int, ...], frozenset[str], bool]] = {}

    def of(self, test: ir.Expr, game: ir.Game) -> tuple[tuple[int, ...], frozenset[str], bool]:
        """Returns the achievers by index, the variables whose fields the condition reads, and whether waiting may achieve it as well."""
        if id(test) not in self._known:
            read = set(reads(test))
            writers = tuple(i for i, r in enumerate(self.preconditions) if r.writes & read and can_make(r, test))
            owners = frozenset(n.owner.name for n in ir.walk(test) if isinstance(n, ir.FieldRead) and isinstance(n.owner, ir.Member))
            self._known[id(test)] = (test, writers, owners, is_timed(test, game))
        return self._known[id(test)][1:]


class Distances:
    """The distances of one state from statements, by their index among the preconditions."""

    def __init__(self, achievers: Achievers, game: ir.Game, world: World):
        self._achievers, self._preconditions, self._game, self._world = achievers, achievers.preconditions, game, world
        self._here = Instance(board_of(game), world)
        self._agents = [agent for agent, cell in enumerate(world.position) if cell is not None]
        self._needs: dict[tuple[int, Bound], Requirements] = {}
        self._far: dict[tuple[int, Bound], float] = {}
        self._gaps: dict[tuple[object, ...], float] = {}
        self._shut: dict[int, frozenset[Cell]] = {}
        self._joins: dict[tuple[object, ...], list[tuple[Precondition, str, Bound]]] = {}

    def of(self, precondition: int, many: int = 1, bound: Bound = None) -> float:
        """Returns the distance from a statement running for so many agents (of each of its agent variables); inf: no way is seen."""
        node = (self._achievers.first[precondition], bound)
        self._settle(node)
        return self._sum(self._needs[node], many)

    def _settle(self, node: tuple[int, Bound]) -> None:
        """Finds what a statement lacks, what its achievers lack, and so on, as far as that is not known; then iterates their distances."""
        waiting, new = [node], dict[tuple[int, Bound], Requirements]()
        while waiting:
            at = waiting.pop()
            if at in self._needs:
                continue
            needs = self._needs[at] = new[at] = self._look(self._preconditions[at[0]], at[1])
            self._far[at] = math.inf
            waiting += [
                w
                for group in (*(unmet for c in needs.choices for _, unmet in c), needs.everywhere)
                for condition in group
                for w in condition.writers
            ]
        for _ in range(ROUNDS):
            now = {at: self._sum(needs, 1) for at, needs in new.items()}
            if all(self._far[at] == far for at, far in now.items()):
                break
            self._far.update(now)

    def _sum(self, needs: Requirements, many: int) -> float:
        if many > needs.most:
            return math.inf
        total = sum(self._cost(condition, many) for condition in needs.everywhere)
        for i, choices in enumerate(needs.choices):
            is_agent = i < needs.agents
            within = many if is_agent else min(many, needs.each[i])
            costs = [moves + sum(self._cost(condition, within) for condition in unmet) for moves, unmet in choices]
            if is_agent and many > 1:
                total += cheapest(costs, needs.stands[i], min(many, len(self._agents)))
                continue
            wanted = -(-within // max(1, needs.each[i]))
            total += sum(sorted(costs)[:wanted]) if costs and len(costs) >= wanted else math.inf
        return total

    def _cost(self, condition: UnmetCondition, many: int) -> float:
        waiting = WAITING * condition.gap if condition.timed else math.inf
        if condition.gathers and many > 1:
            return min([waiting, *(condition.gap * (1 + self._sum(self._needs[writer], many)) for writer in condition.writers)])
        return min([waiting, *(condition.gap * (1 + self._far[writer]) for writer in condition.writers)])

    def _look(self, precondition: Precondition, bound: Bound) -> Requirements:
        needs = Requirements()
        names = [*precondition.agents, *precondition.cells, *precondition.movers]
        tests: dict[str, list[tuple[frozenset[str], ir.Expr]]] = {name: [] for name in names}
        for named, test in precondition.tests:
            owner = next((name for name in names if name in named), None)
            if owner is None:
                condition = self._unmet(precondition, test, {})
                needs.everywhere += [condition] if condition is not None else []
            else:
                tests[owner].append((named, test))
        for name in names:
            values = self._values(precondition, name, bound)
            unmet = [
                [condition for named, test in tests[name] if (condition := self._least(precondition, named, test, name, v, bound))]
                for v in values
            ]
            paths = [
                self._moves(precondition, name, v, bound) + self._moves_to_others(precondition, name, v, bound)
                if name in precondition.agents
                else 0.0
                for v in values
            ]
            found = list(zip(paths, unmet, strict=True))
            if name not in precondition.agents:
                found = sorted(found, key=lambda choice: sum(condition.gap for condition in choice[1]))[:NEAREST]
            needs.choices.append(found)
            needs.agents += name in precondition.agents
            if name in precondition.agents:
                needs.stands.append([self._stands(precondition, name, v, bound) for v in values])
        needs.most = most(precondition.quantifiers, self._here.board)
        needs.each = [most(precondition.quantifiers, self._here.board, name) for name in names]
        return needs

    def _moves(self, precondition: Precondition, name: str, agent: Value, bound: Bound) -> float:
        """Returns the moves of an agent until it reaches, or stands on, cells of a statement, weighted; inf: there is no path."""
        wanted = self._wanted(precondition, name)
        board, node = board_of(self._game), node_of(agent, self._world, board_of(self._game))
        if node is None:
            return math.inf
        total = 0.0
        for shape, member in wanted:
            cells, before = self._places(precondition, member, bound), total
            closed = self._closed(agent)
            total += math.inf
            for price, around in ((0.0, closed | others_of(agent, self._world)), (PAST_AGENTS, closed), (PAST_CLOSED, frozenset[Cell]())):
                moves = least_moves(board, node, cells, shape, around)
                if moves < FAR:
                    total = before + price + MOVE * moves
                    break
        return total

    def _closed(self, agent: int) -> frozenset[Cell]:
        if agent not in self._shut:
            self._shut[agent] = closed_to(agent, self._world, self._here.board)
        return self._shut[agent]

    def _moves_to_others(self, precondition: Precondition, name: str, agent: Value, bound: Bound) -> float:
        """Returns the moves of an agent that has to join others, weighted; inf: there is no path to any of the best cells."""
        total = 0.0
        for _, gathered in (pair for pair in precondition.gathers if pair[0] == name):
            joining = self._joining(precondition, gathered, bound)
            paths = [self._moves(w, joins, agent, one) for w, joins, one in joining]
            total += min(paths, default=0.0)
        return total

    def _joining(self, precondition: Precondition, gathered: ir.Expr, bound: Bound) -> list[tuple[Precondition, str, Bound]]:
        """Returns the statements that add agents to a set, each with who joins and whose set it is: of the cells where it would do most."""
        key = (id(gathered), bound)
        if key not in self._joins:
            cells = precondition.cells_for(gathered, self._game, self._world, bound)
            joined = [w for w in self._preconditions if w.joins is not None and w.writes & set(reads(gathered))]
            self._joins[key] = [
                (w, w.joins, o)
                for w in joined
                if w.joins
                for o in ([(w.owner, c) for c in cells if can_be(w, w.owner, c)] if w.owner and w.owner not in w.agents else [None])
            ]
        return self._joins[key]

    def _wanted(self, precondition: Precondition, name: str) -> list[tuple[str | None, str]]:
        """Returns the cells and movers that an agent must have in a shape, or, for None, the cells it must be on."""
        things = {*precondition.cells, *precondition.movers}
        reached = [(shape, member) for anchor, shape, member in precondition.reaches if anchor == name and member in things]
        return [*reached, *((None, member) for member, kinds in precondition.cells.items() if kinds == precondition.on.get(name))]

    def _stands(self, precondition: Precondition, name: str, agent: Value, bound: Bound) -> frozenset[Cell] | None:
        """Returns the cells on which an agent can stand for its role, or to join for it, and to which it can go; None: anywhere."""
        board, node = board_of(self._game), node_of(agent, self._world, board_of(self._game))
        asked = [(precondition, name, bound)]
        for _, gathered in (pair for pair in precondition.gathers if pair[0] == name):
            asked += self._joining(precondition, gathered, bound)
        wanted = [(shape, cell) for r, n, b in asked for shape, member in self._wanted(r, n) for cell in self._places(r, member, b)]
        found = {(shape, cell, at) for shape, cell in wanted for at in stands(board, cell, shape)}
        return frozenset(at for shape, cell, at in found if can_go(node, board, cell, shape, at)) if wanted else None

    def _values(self, precondition: Precondition, name: str, bound: Bound) -> Sequence[Value]:
        return precondition.values(name, self._game, self._world, bound)

    def _places(self, precondition: Precondition, name: str, bound: Bound) -> Sequence[Cell]:
        """Returns the cells that a variable can stand for, or on which the movers are that it can stand for."""
        cells = (place_of(value, self._world) for value in self._values(precondition, name, bound))
        return [cell for cell in cells if cell is not None]

    def _least(
        self, precondition: Precondition, named: frozenset[str], test: ir.Expr, name: str, value: Value, bound: Bound
    ) -> UnmetCondition | None:
        """Returns what a condition unmet with one variable chosen and the others at their best; None if it holds or cannot be judged."""
        others = [n for n in named if n != name]
        known = {*precondition.cells, *precondition.agents, *precondition.movers}
        if len(others) > 1 or not known.issuperset(others):
            return None
        best: UnmetCondition | None = None
        for rest in product(*(self._values(precondition, n, bound) for n in others)):
            condition = self._unmet(precondition, test, {name: value, **dict(zip(others, rest, strict=True))})
            if condition is None:
                return None
            best = condition if best is None or condition.gap < best.gap else best
        return best or UnmetCondition(math.inf, (), False)

    def _unmet(self, precondition: Precondition, test: ir.Expr, names: Mapping[str, Value]) -> UnmetCondition | None:
        gap = self._gap(test, names)
        if not gap:
            return None
        writers, owners, timed = self._achievers.of(test, self._game)
        values = {names[owner] for owner in owners if owner in names}
        gathers = any(test is gathered for _, gathered in precondition.gathers)
        first = self._achievers.first
        return UnmetCondition(
            gap, tuple(dict.fromkeys((first[i], _whose(self._preconditions[i], values)) for i in writers)), timed, gathers
        )

    def _gap(self, test: ir.Expr, names: Mapping[str, Value]) -> float:
        """Returns the branch distance of a condition, computed once even if many statements depend on it."""
        key = (id(test), *names.items())
        if key not in self._gaps:
            try:
                self._gaps[key] = branch_distance(test, self._here.only(names))
            except AssertionError:  # a field of no agent is read: another condition guards it
                self._gaps[key] = FAILED
        return self._gaps[key]


def _needs_of(precondition: Precondition) -> tuple[object, ...]:
    """Returns what tells a statement from others in what it needs, whatever it writes."""
    parts = (precondition.agents, tuple(precondition.cells.items()), tuple(precondition.on.items()), precondition.reaches)
    return (
        *parts,
        *precondition.movers.items(),
        *map(id, precondition.quantifiers),
        *((name, id(test)) for name, test in precondition.gathers),
        *(id(test) for _, test in precondition.tests),
    )


def cheapest(costs: Sequence[float], places: Sequence[frozenset[Cell] | None], number: int) -> float:
    """Returns the least sum of costs of so many agents that can all stand apart; inf if there are not so many. None: anywhere."""
    able = sorted((price, i) for i, price in enumerate(costs) if price < math.inf)[:ABLE]
    groups = sorted((sum(price for price, _ in group), [i for _, i in group]) for group in combinations(able, number))
    return next((price for price, group in groups if _stand_apart([places[i] for i in group])), math.inf)


def _stand_apart(places: Sequence[frozenset[Cell] | None]) -> bool:
    """Returns whether each agent can have a cell of its own (a bipartite matching)."""
    short = sorted((cells for cells in places if cells is not None and len(cells) < len(places)), key=len)  # others always find one
    return not short or any(_stand_apart([c - {cell} for c in short[1:]]) for cell in short[0])


def _whose(writer: Precondition, values: Collection[Value]) -> Bound:
    """Returns the agent, mover or cell for which a statement has to write, given those that a condition reads."""
    if writer.owner is None:
        return None
    fitting = [v for v in values if can_be(writer, writer.owner, v)]
    return (writer.owner, fitting[0]) if len(fitting) == 1 else None


def branch_distance(test: ir.Expr, here: Instance) -> float:
    """Returns the branch distance of a condition: 0 if it holds, otherwise the difference of its numbers, or 1 if it compares none."""
    match test:
        case ir.Named():
            return branch_distance(test.value, here)
        case ir.Logic():
            each = [branch_distance(arg, here) for arg in test.args] if not evaluate(test, here) else [0.0]
            return sum(each) if test.fn == "and" else min(each)
        case ir.Compare() if not evaluate(test, here) and test.fn != "!=":
            return _steps(evaluate(test.left, here), evaluate(test.right, here))
        case ir.InRange() if not evaluate(test, here):
            value = evaluate(test.value, here)
            return min(_steps(value, evaluate(test.low, here)), _steps(value, evaluate(test.high, here)))
        case _:
            return 0.0 if evaluate(test, here) else FAILED


def _steps(left: Value, right: Value) -> float:
    """Returns the difference of two numbers, at least 1."""
    apart = float(abs(left - right)) if isinstance(left, int) and isinstance(right, int) else min(MOST, abs(float(left) - float(right)))
    return max(FAILED, apart if apart <= MOST else MOST + math.log2(apart / MOST))

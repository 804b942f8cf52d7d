"""Preconditions of a statement, read off its text: which agents act how, and which cells or agents must be in reach."""

from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from random import Random

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import action_named, all_fields, body_sorts, contains, written_field
from sjdsl.interpreter import numbers
from sjdsl.interpreter.board import board_of, cells_of
from sjdsl.interpreter.bodies import where_is
from sjdsl.interpreter.evaluate import arguments_of, evaluate
from sjdsl.interpreter.instance import Instance
from sjdsl.interpreter.state import Cell, Mover, Value, World
from sjdsl.properties.effects import STEP, field_part, part_of, reads, written_by
from sjdsl.properties.effects import Part as Written
from sjdsl.properties.multiplicity import Quantifier
from sjdsl.properties.statements import LeafStatement, StatementId

BACKWARDS = 0.95  # how often the unmet conditions of a statement are achieved first
JOINING = (1, 2, 2, 3)  # how many agents are sent where agents join a set
MOST = 4  # statements that are worked towards at once
NEVER = 4.0  # how much more often a statement that never ran is chosen than one that ran once


Bound = tuple[str, Value] | None  # a variable and its value: a cell, an agent or a mover


@dataclass(frozen=True)
class Precondition:
    """What a statement needs to run, and what it writes.

    agents, cells, movers: the variables of its domains and guards; cells with the kinds they can be of, movers with their sort. actions:
    what an agent must choose; on: kinds of cells on which it must stand. reaches: (agent, shape, whoever or whatever must be in it, or
    around which the shape reaches the agent as well). tests: conditions, with the
    variables they name. writes: what the statement changes; sets, adds: the value it sets, or adds; owner: whose field that is; joins:
    which agent it adds to a set. gathers: agents that must be in a set, each with the condition that the set is not empty.
    quantifiers: those around it; block: other statements under the same conditions, which run when it does.
    """

    statement_id: StatementId
    writes: frozenset[Written]
    sets: ir.Expr | None
    adds: ir.Expr | None
    owner: str | None
    joins: str | None
    gathers: tuple[tuple[str, ir.Expr], ...]
    agents: tuple[str, ...]
    cells: Mapping[str, tuple[str, ...]]
    movers: Mapping[str, str]
    actions: Mapping[str, tuple[int, ...]]
    on: Mapping[str, tuple[str, ...]]
    reaches: tuple[tuple[str, str, str], ...]
    tests: tuple[tuple[frozenset[str], ir.Expr], ...]
    quantifiers: tuple[Quantifier, ...]
    block: tuple[object, ...]

    def fitting_agents(self, name: str, game: ir.Game, world: World) -> list[int]:
        """Returns the agents for which all conditions hold, except on their action and on where they stand.

        They have a cell or a mover to reach for which the rest holds.
        """
        here = [agent for agent, cell in enumerate(world.position) if cell is not None]
        fitting = [agent for agent in here if self._holds({name: agent}, game, world)]
        wanted = [member for anchor, _, member in self.reaches if anchor == name and (member in self.cells or member in self.movers)]
        return [a for a in fitting if not wanted or any(self.fitting_members(member, game, world, {name: a}) for member in wanted)]

    def unmet(self, game: ir.Game, world: World, many: int, bound: Bound = None) -> list[ir.Expr]:
        """Returns the unmet conditions: those that hold for no agent and no cell, or not together, or for fewer than `many` agents.

        bound: a cell that is given.
        """
        unmet = [test for named, test in self.tests if not self._is_met(named, test, game, world, bound)]
        wanted = min(many, sum(cell is not None for cell in world.position))
        for name in self.agents:
            if len(self.fitting_agents(name, game, world)) < wanted:
                unmet += [test for named, test in self.tests if name in named]
        for name in (*self.cells, *self.movers):
            if not unmet and not self.fitting_members(name, game, world, {}, bound):
                unmet += [test for named, test in self.tests if named == {name}]
        return list({id(test): test for test in unmet}.values())

    def _is_met(self, named: frozenset[str], test: ir.Expr, game: ir.Game, world: World, bound: Bound) -> bool:
        """Returns whether a condition holds for any choice of its variables; with more than two of them it is taken to hold."""
        choices = [self.values(n, game, world, bound) for n in named]
        if len(named) > 2:
            return True
        for values in product(*choices):
            here_now = Instance(board_of(game), world, names=dict(zip(named, values, strict=True)))
            try:
                if evaluate(test, here_now):
                    return True
            except AssertionError:  # a field of no agent is read: another test guards it
                continue
        return False

    def values(self, name: str, game: ir.Game, world: World, bound: Bound) -> Sequence[Value]:
        """Returns what a variable can stand for now: cells of its kinds, and movers of its sort or agents that are not away."""
        if bound is not None and bound[0] == name:  # of a group, a cell may be of a kind of which this statement does not speak
            fits = name not in self.cells or board_of(game).kind_of[bound[1]] in self.cells[name]
            return [bound[1]] if fits else []
        if name in self.cells:
            return cells_of(board_of(game), self.cells[name])
        if name in self.movers:
            sort = self.movers[name]
            return [Mover(sort, number) for number, cell in enumerate(world.movers[sort].position) if cell is not None]
        return [agent for agent, cell in enumerate(world.position) if cell is not None]

    def cells_for(self, test: ir.Expr, game: ir.Game, world: World, bound: Bound) -> list[Value]:
        """Returns the cells or movers for which a condition is best made true: most of their other conditions hold; [] if it names none."""
        named = next(named for named, known in self.tests if known is test)
        name = next((n for n in (*self.cells, *self.movers) if n in named), None)
        if name is None:
            return []
        others = [t for n, t in self.tests if n == {name}]
        failing = {
            c: sum(not self._is_met(frozenset({name}), t, game, world, (name, c)) for t in others)
            for c in self.values(name, game, world, bound)
        }
        return [cell for cell, number in failing.items() if number == min(failing.values())]

    def fitting_members(self, name: str, game: ir.Game, world: World, agent: Mapping[str, int], bound: Bound = None) -> list[Value]:
        """Returns the cells, or movers, for which every condition on them, and on them and an agent, holds."""
        return [value for value in self.values(name, game, world, bound) if self._holds({**agent, name: value}, game, world)]

    def _holds(self, names: Mapping[str, Value], game: ir.Game, world: World) -> bool:
        here = Instance(board_of(game), world, names=names)
        try:
            return all(evaluate(test, here) for named, test in self.tests if named and named <= set(names))
        except AssertionError:  # a field of no agent is read, which a test that is not evaluated here would guard
            return False


def preconditions_of(leaves: Iterable[LeafStatement], game: ir.Game) -> tuple[Precondition, ...]:
    """Returns the preconditions of statements, without those that need nothing of agents."""
    gathering: dict[int, ir.Expr] = {}
    return tuple(r for r in (_precondition(leaf, gathering, game) for leaf in leaves) if r.agents or r.cells or r.movers)


def choose_precondition(preconditions: Collection[Precondition], ran: Counter[StatementId], random: Random) -> Precondition:
    """Returns the precondition of a random statement, more often one that seldom ran."""
    weights = [1 / (1 + ran[r.statement_id]) ** 0.5 if ran[r.statement_id] else NEVER for r in preconditions]
    return random.choices(list(preconditions), weights)[0]


@dataclass(frozen=True)
class Goal:
    """A statement, by its index among the preconditions, that is to run for so many agents, or so many times, in one step."""

    precondition: int
    many: int


@dataclass(frozen=True)
class Role:
    """One agent's role in a statement; `rather`: the agents that should have it, empty for any; `bound`: a cell of it that is given."""

    precondition: Precondition
    name: str
    rather: tuple[int, ...] = ()
    bound: Bound = None


def roles_towards(
    goal: Goal,
    preconditions: Sequence[Precondition],
    game: ir.Game,
    world: World,
    random: Random,
    seen: frozenset[StatementId] = frozenset(),
    bound: Bound = None,
) -> list[Role]:
    """Returns roles that agents can take now so that a statement can run later: its own, or those of statements that achieve its conditions."""
    focus = preconditions[goal.precondition]
    unmet = focus.unmet(game, world, 1, bound) if random.random() < BACKWARDS else []
    gathering = [test for test in unmet if any(test is gathered for _, gathered in focus.gathers)]
    if not seen and len(gathering) == len(unmet):  # it could run: perhaps first for more of them at once
        unmet += focus.unmet(game, world, goal.many, bound)
    unmet = [test for test in unmet if not any(test is gathered for gathered in gathering)] or gathering
    seen |= {focus.statement_id}
    found: list[Role] = []
    for test in random.sample(unmet, min(len(unmet), MOST)):
        if len(found) >= MOST:  # no more are taken, and each further one may need many of its own
            break
        gathered = [focus.fitting_agents(name, game, world) for name, condition in focus.gathers if condition is test]
        read = set(reads(test))
        writers = [i for i, r in enumerate(preconditions) if r.statement_id not in seen and r.writes & read and can_make(r, test)]
        if not writers or (gathered and not any(gathered)):  # the agents to gather have to fit first
            continue
        chosen = random.choice(writers)
        writer = preconditions[chosen]
        wanted = tuple(agent for agents in gathered for agent in agents)
        cells = focus.cells_for(test, game, world, bound) if writer.owner in writer.cells or writer.owner in writer.movers else []
        cells = [c for c in cells if can_be(writer, writer.owner, c)]
        given = (writer.owner, random.choice(cells)) if writer.owner is not None and cells else None
        for part in roles_towards(Goal(chosen, 1), preconditions, game, world, random, seen, given):
            joining = part.precondition is writer and part.name == writer.joins
            found += [replace(part, rather=wanted)] * (goal.many if goal.many > 1 else random.choice(JOINING)) if joining else [part]
    return found[:MOST] or [Role(focus, name, (), bound) for name in focus.agents or ("",)] * goal.many


def can_make(precondition: Precondition, test: ir.Expr) -> bool:
    """Returns whether a statement could make a condition true; not if it sets the field to a wrong value, or moves it the wrong way."""
    match test:
        case ir.Same(right=ir.Word(value=wanted)) if isinstance(precondition.sets, ir.Word):
            return precondition.sets.value == wanted
        case ir.InWords(words=words) if isinstance(precondition.sets, ir.Word):
            return precondition.sets.value in words
        case ir.Not(value=ir.IsEmpty()):
            return not isinstance(precondition.sets, ir.Nobody)
        case ir.Compare(left=ir.FieldRead(), right=ir.Number(value=wanted)) if isinstance(precondition.sets, ir.Number):
            return numbers.compare(test.fn, precondition.sets.value, wanted)
        case ir.Compare(left=ir.FieldRead(), fn="<" | "<=" | ">" | ">=") if isinstance(precondition.adds, ir.Number):
            return (precondition.adds.value > 0) == (test.fn in (">", ">="))
        case _:
            return True


def can_be(precondition: Precondition, name: str | None, value: Value) -> bool:
    """Returns whether a variable of a statement can stand for an agent, a mover or a cell."""
    if isinstance(value, Mover):
        return name is not None and precondition.movers.get(name) == value.sort
    return name in (precondition.agents if isinstance(value, int) else precondition.cells)


def place_of(member: Value, world: World) -> Cell | None:
    """Returns a cell itself, or the cell of an agent or a mover."""
    return member if isinstance(member, Cell) else where_is(member, world)


def _precondition(leaf: LeafStatement, gathering: dict[int, ir.Expr], game: ir.Game) -> Precondition:
    """Returns what a statement needs. gathering: by the identity of a set, the condition that it is not empty, shared by all under it."""
    nodes = [n for node in (*leaf.around, leaf.statement) for n in ir.walk(node)]
    domains = [n for n in nodes if isinstance(n, ir.Domain)]
    conditions = [part for d in domains if d.where is not None for part in _parts(d.where)]
    conditions += [part for node in leaf.around if node.__class__ is not ir.Domain for part in _parts(node)]
    within = [d for d in domains if isinstance(d.restriction, ir.InAgents)]
    places = [(d.var.name, d.restriction.value) for d in within if isinstance(d.restriction, ir.InAgents)]
    gathers = [(name, gathering.setdefault(id(agents), ir.Not(value=ir.IsEmpty(container=agents)))) for name, agents in places]
    conditions += [gathered for _, gathered in gathers]
    actions: dict[str, tuple[int, ...]] = {}
    on: dict[str, tuple[str, ...]] = {d.var.name: d.on.kinds for d in domains if d.on is not None}
    cells = {d.var.name: d.var.kinds for d in domains if d.var.sort.what == "cell"} | {
        d.on.name: d.on.kinds for d in domains if d.on is not None
    }
    movers = {d.var.name: d.var.sort.name for d in domains if d.var.sort.what == "mover"}
    tests = []
    for e in conditions:
        match e:
            case ir.Chose(agent=ir.Member(name=name)):
                actions[name] = tuple(dict.fromkeys((*actions.get(name, ()), e.action)))
            case ir.ChoseWith(agent=ir.Member(name=name)):
                actions[name] = tuple(dict.fromkeys((*actions.get(name, ()), *_fitting_actions(e, game))))
            case ir.StandsOn(agent=ir.Member(name=name)):
                on[name] = e.kinds
            case _ if ir.is_expression(e) and e.type.kind == "condition" and not _is_open(e):
                tests.append((frozenset(n.name for n in ir.walk(e) if isinstance(n, ir.Member)) - _bound(e), e))
            case _:
                pass
    directed = {shape.name for shape in game.shapes if shape.directed}
    reaches = [
        (d.restriction.anchor.name, d.restriction.shape, d.var.name)
        for d in domains
        if isinstance(d.restriction, ir.Near) and d.restriction.anchor.sort.what == "agent"
    ]
    reaches += [
        (d.var.name, d.restriction.shape, d.restriction.anchor.name)
        for d in domains
        if isinstance(d.restriction, ir.Near) and d.var.sort.what == "agent" and d.restriction.anchor.sort.what == "mover"
        if d.restriction.shape not in directed
    ]
    agents = tuple(dict.fromkeys(d.var.name for d in domains if d.var.sort.what == "agent"))
    joins = leaf.statement.value.name if isinstance(leaf.statement, ir.Add) and isinstance(leaf.statement.value, ir.Member) else None
    return Precondition(
        leaf.statement_id,
        frozenset(written_by(leaf.statement)),
        leaf.statement.value if isinstance(leaf.statement, ir.Set) else None,
        leaf.statement.value if isinstance(leaf.statement, ir.Add) else None,
        _owner(leaf.statement),
        joins,
        tuple(gathers),
        agents,
        cells,
        movers,
        actions,
        on,
        tuple(reaches),
        tuple(tests),
        leaf.quantifiers,
        (leaf.statement_id[0], isinstance(leaf.statement, ir.Move), *map(id, (*leaf.around, *leaf.quantifiers))),
    )


def _fitting_actions(e: ir.ChoseWith, game: ir.Game) -> list[int]:
    """Returns the actions by which a condition on the chosen action may hold: those with the arguments that are written out."""
    action = action_named(game, e.action)
    fixed = {i: given.value.value for i, given in enumerate(e.given) if isinstance(given.value, ir.Number | ir.Word)}
    found = []
    for number in action.numbers:
        values = arguments_of(action, number)
        assert values is not None
        if all(values[i] == value for i, value in fixed.items()):
            found.append(number)
    return found


def _owner(statement: ir.Stmt) -> str | None:
    """Returns the variable whose field a statement writes."""
    owner = written_field(statement.target).owner if isinstance(statement, ir.Set | ir.Add) else None
    return owner.name if isinstance(owner, ir.Member) else None


def is_timed(test: ir.Expr, game: ir.Game) -> bool:
    """Returns whether a condition may come to hold by waiting: it reads a timer, who is away, or the number of the step."""
    timers = {field_part(f.held_by.what, f.held_by.name, f.name) for f in all_fields(game) if f.timer}
    away = {part_of("away", sort) for sort in body_sorts(game)}
    return bool(set(reads(test)) & (timers | away | {STEP}))


def _parts(e: ir.Node) -> Iterator[ir.Node]:
    """Yields the conditions of a conjunction."""
    if isinstance(e, ir.Logic) and e.fn == "and":
        for arg in e.args:
            yield from _parts(arg)
    elif isinstance(e, ir.Named):
        yield from _parts(e.value)
    else:
        yield e


def _bound(e: ir.Node) -> frozenset[str]:
    domains = [n for n in ir.walk(e) if isinstance(n, ir.Domain)]
    return frozenset(name for d in domains for name in (d.var.name, *((d.on.name,) if d.on is not None else ())))


def _is_open(e: ir.Node) -> bool:
    """Returns whether a condition reads what is not known between two steps: actions, and values bound by `let` or `draw`."""
    return contains(e, ir.Chose, ir.ChoseWith, ir.ArgumentOf, ir.Local)

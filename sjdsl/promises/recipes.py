"""What a sentence needs to take place, read off its text: who acts how, and which cells or agents must be where they reach."""

from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import product
from random import Random

from sjdsl.compiler import ir
from sjdsl.interpreter.board import board_of, cells_of
from sjdsl.interpreter.evaluate import evaluate
from sjdsl.interpreter.instance import Instance
from sjdsl.interpreter.state import Cell, Value, World
from sjdsl.promises.sentences import Leaf, Place
from sjdsl.promises.touches import Part as Written
from sjdsl.promises.touches import reads, written_by

BACKWARDS = 0.85  # how often what a sentence lacks is brought about first
AT_ONCE = (1, 1, 2, 3)  # for how many agents a sentence is to take place
JOINING = (1, 2, 2, 3)  # how many are sent where agents are gathered in a set
MOST = 4  # sentences that are brought about at once
NEVER = 4.0  # how much more often a sentence that never ran is looked for than one that ran once


@dataclass(frozen=True)
class Recipe:
    """What a sentence needs.

    agents, cells: the variables of its domains and guards; cells with the kinds they can be of. actions: what an agent must choose; on: kinds
    of cells on which it must stand. reaches: (agent, shape, agent or cell that must be in it). tests: conditions, with the variables they
    name. writes: what the sentence changes; word: what it sets that to, if it is one word; joins: which agent
    it adds to a set. gathers: agents that must be in a set, each with the condition that the set is not empty.
    """

    place: Place
    writes: frozenset[Written]
    word: str | None
    joins: str | None
    gathers: tuple[tuple[str, ir.Expr], ...]
    agents: tuple[str, ...]
    cells: Mapping[str, tuple[str, ...]]
    actions: Mapping[str, tuple[int, ...]]
    on: Mapping[str, tuple[str, ...]]
    reaches: tuple[tuple[str, str, str], ...]
    tests: tuple[tuple[frozenset[str], ir.Expr], ...]

    def fitting_agents(self, name: str, game: ir.Game, world: World) -> list[int]:
        """Returns the agents for which everything holds that is said of them, but what they choose and where they stand.

        They have a cell to reach for which the rest holds.
        """
        here = [agent for agent, place in enumerate(world.position) if place is not None]
        fitting = [agent for agent in here if self._holds({name: agent}, game, world)]
        wanted = [member for anchor, _, member in self.reaches if anchor == name and member in self.cells]
        return [a for a in fitting if not wanted or any(self.fitting_cells(member, game, world, {name: a}) for member in wanted)]

    def unmet(self, game: ir.Game, world: World, many: int) -> list[ir.Expr]:
        """Returns the conditions that hold for no agent and no cell, or not together, or for fewer than `many` agents."""
        lacking = [test for named, test in self.tests if not self._is_met(named, test, game, world)]
        wanted = min(many, sum(place is not None for place in world.position))
        for name in self.agents:
            if len(self.fitting_agents(name, game, world)) < wanted:
                lacking += [test for named, test in self.tests if name in named]
        for name in self.cells:
            if not lacking and not self.fitting_cells(name, game, world, {}):
                lacking += [test for named, test in self.tests if named == {name}]
        return list({id(test): test for test in lacking}.values())

    def _is_met(self, named: frozenset[str], test: ir.Expr, game: ir.Game, world: World) -> bool:
        """Returns whether a condition holds for any choice of its variables; with more than two of them that is not looked at."""
        here = [agent for agent, place in enumerate(world.position) if place is not None]
        choices: list[list[Value]] = [list(cells_of(board_of(game), self.cells[n])) if n in self.cells else list(here) for n in named]
        if len(named) > 2:
            return True
        for values in product(*choices):
            here_now = Instance(board_of(game), world, names=dict(zip(named, values, strict=True)))
            try:
                if evaluate(test, here_now):
                    return True
            except AssertionError:  # read of nobody: another test protects
                continue
        return False

    def fitting_cells(self, name: str, game: ir.Game, world: World, agent: Mapping[str, int]) -> list[Cell]:
        """Returns the cells for which everything said of them, and of them and an agent, holds."""
        candidates = cells_of(board_of(game), self.cells[name])
        return [cell for cell in candidates if self._holds({**agent, name: cell}, game, world)]

    def _holds(self, names: Mapping[str, Value], game: ir.Game, world: World) -> bool:
        here = Instance(board_of(game), world, names=names)
        try:
            return all(evaluate(test, here) for named, test in self.tests if named and named <= set(names))
        except AssertionError:  # something is read of nobody, where a test that is not looked at here would protect
            return False


def recipes_of(leaves: Iterable[Leaf]) -> tuple[Recipe, ...]:
    """Returns the recipes of sentences, without those that need nothing of agents."""
    return tuple(r for r in map(_recipe, leaves) if r.agents or r.cells)


def choose_recipe(recipes: Collection[Recipe], ran: Counter[Place], random: Random) -> Recipe:
    """Returns a recipe, rather one of a sentence that seldom ran."""
    weights = [1 / (1 + ran[r.place]) ** 0.5 if ran[r.place] else NEVER for r in recipes]
    return random.choices(list(recipes), weights)[0]


@dataclass(frozen=True)
class Part:
    """One agent's part in a sentence; `rather`: the agents that should have it, empty for any."""

    recipe: Recipe
    name: str
    rather: tuple[int, ...] = ()


def parts_towards(
    focus: Recipe, recipes: Collection[Recipe], game: ir.Game, world: World, random: Random, seen: frozenset[Place] = frozenset()
) -> list[Part]:
    """Returns what agents can do now so that a sentence can take place later: its own parts, or, for what it lacks, those of others."""
    lacking = focus.unmet(game, world, 1) if random.random() < BACKWARDS else []
    gathering = [test for test in lacking if any(test is gathered for _, gathered in focus.gathers)]
    if not seen and len(gathering) == len(lacking):  # it could take place: perhaps first for more of them at once
        lacking += focus.unmet(game, world, random.choice(AT_ONCE))
    lacking = [test for test in lacking if not any(test is gathered for gathered in gathering)] or gathering
    seen |= {focus.place}
    found: list[Part] = []
    for test in random.sample(lacking, min(len(lacking), MOST)):
        gathered = [focus.fitting_agents(name, game, world) for name, condition in focus.gathers if condition is test]
        read = set(reads(test))
        writers = [r for r in recipes if r.place not in seen and r.writes & read and _can_make(r, test)]
        if not writers or (gathered and not any(gathered)):  # those who could be gathered have to be made first
            continue
        writer = random.choice(writers)
        wanted = tuple(agent for agents in gathered for agent in agents)
        for part in parts_towards(writer, recipes, game, world, random, seen):
            joining = part.recipe is writer and part.name == writer.joins
            found += [Part(writer, part.name, wanted)] * random.choice(JOINING) if joining else [part]
    return found[:MOST] or [Part(focus, name) for name in focus.agents or ("",)]


def _can_make(recipe: Recipe, test: ir.Expr) -> bool:
    """Returns whether a sentence could make a condition true: it does not set the field to another word than the one asked for."""
    if isinstance(test, ir.Same) and isinstance(test.right, ir.Word) and recipe.word is not None:
        return recipe.word == test.right.value
    return True


def _recipe(leaf: Leaf) -> Recipe:
    nodes = [n for node in (*leaf.around, leaf.sentence) for n in ir.walk(node)]
    domains = [n for n in nodes if isinstance(n, ir.Domain)]
    conditions = [part for d in domains if d.where is not None for part in _parts(d.where)]
    conditions += [part for node in leaf.around if node.__class__ is not ir.Domain for part in _parts(node)]
    within = [d for d in domains if isinstance(d.place, ir.InAgents)]
    gathers = [(d.var.name, ir.Not(value=ir.IsEmpty(container=d.place.value))) for d in within if isinstance(d.place, ir.InAgents)]
    conditions += [gathered for _, gathered in gathers]
    actions: dict[str, tuple[int, ...]] = {}
    on: dict[str, tuple[str, ...]] = {d.var.name: d.on.kinds for d in domains if d.on is not None}
    cells = {d.var.name: d.var.kinds for d in domains if d.var.who == "cell"} | {d.on.name: d.on.kinds for d in domains if d.on is not None}
    tests = []
    for e in conditions:
        match e:
            case ir.Chose(agent=ir.Member(name=name)):
                actions[name] = tuple(dict.fromkeys((*actions.get(name, ()), e.action)))
            case ir.StandsOn(agent=ir.Member(name=name)):
                on[name] = e.kinds
            case _ if isinstance(e, ir.Expression) and e.type.kind == "condition" and not _is_open(e):  # type: ignore[attr-defined]
                tests.append((frozenset(n.name for n in ir.walk(e) if isinstance(n, ir.Member)) - _bound(e), e))
            case _:
                pass
    reaches = [
        (d.place.anchor.name, d.place.shape, d.var.name) for d in domains if isinstance(d.place, ir.Near) and d.place.anchor.who == "agent"
    ]
    agents = tuple(dict.fromkeys(d.var.name for d in domains if d.var.who == "agent"))
    value = leaf.sentence.value if isinstance(leaf.sentence, ir.Set) else None
    word = value.value if isinstance(value, ir.Word) else None
    joins = leaf.sentence.value.name if isinstance(leaf.sentence, ir.Add) and isinstance(leaf.sentence.value, ir.Member) else None
    return Recipe(
        leaf.place,
        frozenset(written_by(leaf.sentence)),
        word,
        joins,
        tuple(gathers),
        agents,
        cells,
        actions,
        on,
        tuple(reaches),
        tuple(tests),
    )


def _parts(e: ir.Node) -> Iterator[ir.Node]:
    """Yields the conditions that must all hold for a condition to hold."""
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
    return any(isinstance(n, ir.Chose | ir.Local) for n in ir.walk(e))

"""Random initial scenarios: a small map of the game's glyphs or its own map, few agents, parameters within their limits."""

from dataclasses import replace
from random import Random
from typing import Any

from sjdsl.compiler import ir
from sjdsl.compiler.checks.whole_numbers import beyond_int32
from sjdsl.compiler.ir.evaluate_constant import holds
from sjdsl.interpreter.state import Value
from sjdsl.properties.instances import GameFamily
from sjdsl.properties.trajectory import Scenario

MOST_ROWS, MOST_COLUMNS = 4, 5
SMALL = 64  # own maps of at most so many cells are also used
OWN_MAP = 0.25  # how often the own map is used
AS_WRITTEN = 0.5  # how often a start on the own map has the parameters and the agents of the file
CROWDED = 0.5  # how often there are more than few agents, where that is asked for
OF_ALL = 0.5  # how often a map has a cell of every glyph that there is room for
OTHERS = 0.3  # how often a number is not the file's
OTHERS_ON_OWN_MAP = 0.7  # the same in starts on the own map that are not as written
PLAIN = (0, 3, 9, 27)  # how many times as often one glyph is drawn: where there is little of something, it is soon used up
WORTHS = (0.0, 1.0, -1.0, 2.5)  # of a real number without limits, beside the file's
COUNTS = (0, 1, 2, 5)  # of a whole number without limits


def random_start(family: GameFamily, random: Random, crowded: bool = False) -> Scenario | None:
    """Returns a random scenario without a step; None if the compiler refuses its map.

    crowded: half of the scenarios have more than few agents, up to as many as the game takes: some rules are only of later ones.
    """
    agents = min(random.choice(family.few_agents), random.choice(family.few_agents))
    if crowded and max(family.few_agents) < family.most_agents and random.random() < CROWDED:
        agents = random.randint(max(family.few_agents) + 1, family.most_agents)
    rows = family.own.rows if _is_small(family) and random.random() < OWN_MAP else random_map(family, agents, random)
    if family.on(rows, agents) is None:
        rows += _of_each(family.glyphs, len(rows[0]))
    sizes = random_sizes(family, random)
    sizes = sizes if family.on(rows, agents, sizes) is not None else ()
    game = family.on(rows, agents, sizes)
    if game is None:
        return None
    params = random_params(game, random, OTHERS)
    return Scenario(rows, agents, params, random.randrange(2**16), (), (), (None,) * agents, sizes=sizes)


def own_start(family: GameFamily, random: Random) -> Scenario:
    """Returns a scenario without a step on the game's own map, with all its agents and the parameters of the file."""
    agents = family.own.agents.number
    return Scenario(family.own.rows, agents, (), random.randrange(2**16), (), (), (None,) * agents)


def start_on_own_map(family: GameFamily, random: Random, crowded: bool = False) -> Scenario | None:
    """Returns a scenario without a step on the game's own map; half of them with other parameters and sizes, or other numbers of agents."""
    del crowded
    own = own_start(family, random)
    if random.random() < AS_WRITTEN:
        return own
    agents = random.choice([own.agents, *family.few_agents, random.randint(own.agents, family.most_agents)])
    sizes = random_sizes(family, random)
    game = family.on(own.rows, agents, sizes)
    if game is None:  # a `require` excludes the numbers
        return own
    return replace(own, agents=agents, params=random_params(game, random), policies=(None,) * agents, sizes=sizes)


def random_map(family: GameFamily, agents: int, random: Random) -> tuple[str, ...]:
    """Returns a small map: any glyphs of the game, with enough cells for all agents and movers wherever they are sent."""
    needed = sum(family.needed(sort, agents) for sort, _ in family.destinations) + random.randrange(2 * len(family.glyphs))
    width = random.randint(2, MOST_COLUMNS)
    least = max(2, -(-needed // width))
    height = random.randint(least, max(MOST_ROWS, least))
    often = (*family.glyphs, *[random.choice(family.open_glyphs or family.glyphs)] * random.choice(PLAIN))
    cells = [random.choice(often) for _ in range(width * height)]
    kept: set[int] = set()
    for sort, glyphs in family.destinations:
        many = family.needed(sort, agents)
        here = [i for i, glyph in enumerate(cells) if glyph in glyphs and i not in kept][:many]
        free = [i for i in range(len(cells)) if i not in kept and i not in here]
        more = random.sample(free, many - len(here))
        for i in more:
            cells[i] = glyphs[0]
        kept.update(here, more)
    if random.random() < OF_ALL:
        free = [i for i in range(len(cells)) if i not in kept and cells.count(cells[i]) > 1]
        missing = [glyph for glyph in family.glyphs if glyph not in cells]
        for i, glyph in zip(random.sample(free, len(free)), missing, strict=False):
            cells[i] = glyph
    return tuple("".join(cells[r * width : (r + 1) * width]) for r in range(height))


def _is_small(family: GameFamily) -> bool:
    """Returns whether the interpreter is quick on the game's own map."""
    return len(family.own.rows) * len(family.own.rows[0]) <= SMALL


def _of_each(glyphs: tuple[str, ...], width: int) -> tuple[str, ...]:
    """Returns rows with every glyph, for games that need a cell of each kind (to divide by their number, for example)."""
    rows = ["".join(glyphs[i : i + width]) for i in range(0, len(glyphs), width)]
    return tuple(row.ljust(width, glyphs[0]) for row in rows)


def random_numbers(game: ir.Game, random: Random, share: float = OTHERS) -> tuple[tuple[str, Value], ...]:
    """Returns a share of the parameters with values that differ from the file's, inside their limits; the length of an episode stays."""
    fixed = {n.name for n in ir.walk(game.episode) if isinstance(n, ir.ParamRef)}
    changed = [p for p in game.params if p.name not in fixed and random.random() < share]
    return tuple((p.name, _value(p.value, p.type, random)) for p in changed)


def random_params(game: ir.Game, random: Random, share: float = OTHERS_ON_OWN_MAP) -> tuple[tuple[str, Value], ...]:
    """Returns parameters that differ from the file's, as `random_numbers` does, that keep every `require`."""
    return _required(game, random_numbers(game, random, share))


def random_sizes(family: GameFamily, random: Random) -> tuple[tuple[str, Value], ...]:
    """Returns some sizes that differ from the file's, inside their limits."""
    changed = [(size, _value(size.value, size.type, random)) for size in family.free_sizes if random.random() < OTHERS]
    return tuple((size.name, value) for size, value in changed if value != size.value)


def _value(own: Any, type_: ir.Type, random: Random) -> Value:
    if type_.by:
        inner = type_.model_copy(update={"by": type_.by[1:]})
        return tuple(_value(entry, inner, random) for entry in own)
    if type_.kind == "word":
        return random.choice(type_.words)
    ends = [x for x in (type_.low, type_.high) if abs(x) < 2**31]
    inside = [x for x in (COUNTS if type_.kind == "int" else WORTHS) if type_.low <= x <= type_.high]
    if len(ends) == 2:
        inside.append((type_.low + type_.high) // 2 if type_.kind == "int" else random.uniform(type_.low, type_.high))
    value = random.choice([own, *ends, *inside])
    return int(value) if type_.kind == "int" else float(value)


def _required(game: ir.Game, changed: tuple[tuple[str, Value], ...]) -> tuple[tuple[str, Value], ...]:
    """Returns the changed parameters, without those of a `require` that they violate; none if whole numbers could leave int32."""
    own = {p.name: p.value for p in game.params}
    requires = [c for c in game.checks if c.sort == "require"]
    for check in requires:
        if not holds(check.values[0], own | dict(changed)):
            named = {n.name for n in ir.walk(check) if isinstance(n, ir.ParamRef)}
            changed = tuple((name, value) for name, value in changed if name not in named)
    values = own | dict(changed)
    fitting = all(holds(c.values[0], values) for c in requires) and not (changed and beyond_int32(game, values))
    return changed if fitting else ()

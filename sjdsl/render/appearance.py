"""The appearance of a board at one moment, for everything that shows one: what is in each cell, which are marked, who stands where.

A cell or an agent shows what the `look`s that apply say, and then the fields that none of these reads.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from sjdsl.render.colours import BARS, FILLING, SPRITES, Colour, mixed
from sjdsl.render.look import FieldLook, KindLook, Look, Rule, Values
from sjdsl.render.moment import Snapshot
from sjdsl.render.usual import Picture

BAR_STEPS = 8
TINTED = 0.45
CORNERS = 4  # badges that have room
Key = tuple[int, ...]  # a number for each field: a word's, an agent's and 1, eighths of a bar; 0 or 1 for each rule: whether it applies


@dataclass(frozen=True)
class Drawing:
    """A cell. body: what it is; objects: what is there, side by side; badges: in its corners; bars: place among four, eighths."""

    ground: Colour
    body: Picture | None = None
    objects: tuple[Picture, ...] = ()
    badges: tuple[Picture, ...] = ()
    edge: Colour | None = None
    bars: tuple[tuple[int, int], ...] = ()


@dataclass(frozen=True)
class Figure:
    """An agent, or without a number a mover.

    heading: 0 north, 1 east, 2 south, 3 west; held: it can only stay; badges: what it carries, at most four.
    """

    number: int | None
    colour: Colour
    sprite: str = "agent"
    heading: int = 0
    held: bool = False
    badges: tuple[Picture, ...] = ()


@dataclass(frozen=True)
class Appearance:
    """A board, from the bottom up: each cell, the cells that phases have marked, agents and movers.

    drawings: those that occur; cells: `[H, W]` int, the number of each cell's; marks: colour and `[H, W]` bool, each over those before;
    figures: with row and column, who is on the map, each over those before.
    """

    drawings: tuple[Drawing, ...]
    cells: np.ndarray
    marks: tuple[tuple[Colour, np.ndarray], ...]
    figures: tuple[tuple[Figure, int, int], ...]


def appearance_of(look: Look, snapshot: Snapshot) -> Appearance:
    """Returns what is seen of a board."""
    drawings: list[Drawing] = []
    cells = np.zeros((look.height, look.width), int)
    for kind in look.kinds:
        keys, key_of = cell_keys(kind, snapshot.values)
        cells[kind.rows, kind.cols] = len(drawings) + key_of
        drawings += [draw_cell(kind, key) for key in keys]
    marks = tuple((colour, snapshot.marks[label]) for label, colour in look.marks)
    return Appearance(tuple(drawings), cells, marks, tuple((figure, row, col) for _, figure, row, col in standing_figures(look, snapshot)))


def cell_keys(kind: KindLook, values: Values) -> tuple[list[Key], np.ndarray]:
    """Returns the states in which cells of a kind look differently, and the number of each cell's, `[S]`."""
    count = len(kind.rows)
    columns = [shown_values(field, values[field.attribute]) for field in kind.fields]
    columns += [rule.applies(kind.name, values, count).astype(int) for rule in kind.rules]
    if not columns:
        return [()], np.zeros(count, int)
    found, number = np.unique(np.stack(columns, axis=1), axis=0, return_inverse=True)
    return [tuple(map(int, row)) for row in found], number.reshape(-1)


def shown_values(field: FieldLook, values: np.ndarray) -> np.ndarray:
    """Returns `[S]` int: the number of each cell's word, of its agent and 1, or the eighths of its bar, rounded up."""
    match field.holds:
        case "word":
            return values.astype(int)
        case "agents":
            counts = np.bitwise_count(values).reshape(len(values), -1).sum(axis=1)  # large sets are kept in several numbers
        case "agent":
            return values.astype(int) + 1
        case _:
            counts = values.reshape(len(values), -1).sum(axis=1)
    return np.asarray(np.clip(np.ceil(counts / field.full * BAR_STEPS), 0, BAR_STEPS), int)


@lru_cache(maxsize=4096)
def draw_cell(kind: KindLook, key: Key) -> Drawing:
    """Returns what is drawn in a cell of a kind in one of its states."""
    applied = [rule for rule, applies in zip(kind.rules, key[len(kind.fields) :], strict=True) if applies]
    ground, body = kind.ground, kind.body
    for rule in applied:  # the last one that speaks of body or ground counts, and all that speak of badges
        if rule.sprite is not None:
            body = Picture(rule.sprite, rule.colour or SPRITES[rule.sprite])
        elif rule.colour is not None:
            ground = rule.colour
    badges = tuple(dict.fromkeys(rule.badge for rule in applied if rule.badge is not None))[:CORNERS]
    read = frozenset().union(*(rule.reads for rule in applied))
    objects: list[Picture] = []
    edge: Colour | None = None
    bars: list[tuple[int, int]] = []
    places = {field.name: place for place, field in enumerate(field for field in kind.fields if field.sort == "bar")}
    for field, value in zip(kind.fields, key, strict=False):
        if field.name in read:
            continue
        match field.sort:
            case "tint" if field.is_drawn(value):
                ground = mixed(ground, field.colours[value], TINTED)
            case "shape" if field.is_drawn(value):
                objects.append(field.pictures[value])
            case "edge" if value > 0:
                edge = field.colours[value - 1]
            case "bar" if value > 0 and places[field.name] < len(BARS):
                bars.append((places[field.name], value))
    if body is not None and body.sprite not in FILLING:  # a tree with an apple, not an apple over a tree
        objects, badges = [], (*objects, *badges)[:CORNERS]
    return Drawing(ground, body, tuple(objects), badges, edge, tuple(bars))


def main_colour(drawing: Drawing) -> tuple[Colour, bool]:
    """Returns the colour that says most about a cell, and whether anything stands there: for where a cell has but one colour."""
    things = (*drawing.objects, *drawing.badges)
    if drawing.body is not None and drawing.body.sprite != "floor":
        things = (*things, drawing.body)
    stands = bool(things) and things[0].sprite not in FILLING
    return (things[0].colour if things else drawing.ground), stands


def draw_figures(look: Look, snapshot: Snapshot) -> dict[str, list[Figure]]:
    """Returns how each agent is drawn, and, by their sorts, each mover; those that are away among them."""
    values = snapshot.values
    agents = zip(look.agent_colours(values), snapshot.heading.tolist(), snapshot.held.tolist(), strict=True)
    plain = [Figure(number, colour, "agent", heading, held) for number, (colour, heading, held) in enumerate(agents)]
    found = {"agent": _looking("agent", plain, look.rules, look.carried, values)}
    for herd in look.herds:  # movers face their heading
        plain = [Figure(None, herd.colour, herd.sprite, int(heading)) for heading in values[f"{herd.name}_heading"]]
        found[herd.name] = _looking(herd.name, plain, herd.rules, herd.carried, values)
    return found


def standing_figures(look: Look, snapshot: Snapshot) -> Iterator[tuple[str, Figure, int, int]]:
    """Yields who is on the map, each over those before: `agent` or the sort of the mover, its figure, row, column."""
    figures = draw_figures(look, snapshot)
    for sort, number, row, col in snapshot.standing():
        yield sort, figures[sort][number], row, col


def _looking(prefix: str, plain: list[Figure], rules: tuple[Rule, ...], carried: tuple[FieldLook, ...], values: Values) -> list[Figure]:
    """Returns figures after the looks that apply to each, with badges for what it carries. `prefix`: of the attributes of their fields."""
    applied = [rule.applies(prefix, values, len(plain)) for rule in rules]
    figures = []
    for number, figure in enumerate(plain):
        own = [rule for rule, applies in zip(rules, applied, strict=True) if applies[number]]
        for rule in own:
            figure = ruled(figure, rule)
        badges = list(figure.badges)
        read = frozenset().union(*(rule.reads for rule in own))
        for field in carried:
            value = values[field.attribute][number]
            if field.name in read:
                continue
            if field.holds == "word":  # all but the one it has at the start
                badges += [field.pictures[int(value)]] * (int(value) != field.start)
            else:
                badges += [picture for picture, amount in zip(field.pictures, np.reshape(value, -1), strict=True) if amount != 0]
        figures.append(replace(figure, badges=tuple(dict.fromkeys(badges))[:CORNERS]))
    return figures


def ruled(figure: Figure, rule: Rule) -> Figure:
    """Returns a figure after a `look` that applies to it."""
    badges = figure.badges if rule.badge is None else (*figure.badges, rule.badge)
    return replace(figure, sprite=rule.sprite or figure.sprite, colour=rule.colour or figure.colour, badges=badges)

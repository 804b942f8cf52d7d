"""Chooses the parts that draw a cell, an agent or a mover in one state: the `look`s that apply, then the remaining fields."""

from dataclasses import dataclass, replace

import numpy as np

from sjdsl.render.colours import INKS, SPRITES, Colour, mixed
from sjdsl.render.look import FieldLook, HerdLook, KindLook, Look, Rule, Values
from sjdsl.render.sprites import FILLING
from sjdsl.render.usual import Picture

BAR_STEPS = 8
BARS = (INKS[7], *INKS[1:4])  # of the numbers of a cell, in order: at its foot, its head, its left and its right side
TINTED = 0.45
PALE = 0.62  # how much of a held agent is white
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


def draw_cell(kind: KindLook, key: Key) -> Drawing:
    """Returns what is drawn in a cell of a kind in one of its states."""
    applied = [rule for rule, applies in zip(kind.rules, key[len(kind.fields) :], strict=True) if applies]
    drawing = _ruled(Drawing(kind.ground, kind.body), applied)
    read = frozenset().union(*(rule.reads for rule in applied))
    bars = [field for field in kind.fields if field.sort == "bar"]
    for field, value in zip(kind.fields, key, strict=False):
        if field.name not in read:
            drawing = _with_field(drawing, field, value, bars)
    if drawing.body is not None and drawing.body.sprite not in FILLING:  # a tree with an apple, not an apple over a tree
        return replace(drawing, objects=(), badges=(*drawing.objects, *drawing.badges)[:CORNERS])
    return drawing


def main_colour(drawing: Drawing) -> tuple[Colour, bool]:
    """Returns the colour that says most about a cell, and whether anything stands there: for where a cell has but one colour."""
    things = (*drawing.objects, *drawing.badges)
    if drawing.body is not None and drawing.body.sprite != "floor":
        things = (*things, drawing.body)
    stands = bool(things) and things[0].sprite not in FILLING
    return (things[0].colour if things else drawing.ground), stands


def _ruled(drawing: Drawing, rules: list[Rule]) -> Drawing:
    """Returns a drawing after the looks that apply: of body and ground the last one that speaks of it, of badges all."""
    for rule in rules:
        if rule.sprite is not None:
            drawing = replace(drawing, body=Picture(rule.sprite, rule.colour or SPRITES[rule.sprite]))
        elif rule.colour is not None:
            drawing = replace(drawing, ground=rule.colour)
    badges = dict.fromkeys(rule.badge for rule in rules if rule.badge is not None)
    return replace(drawing, badges=tuple(badges)[:CORNERS])


def _with_field(drawing: Drawing, field: FieldLook, value: int, bars: list[FieldLook]) -> Drawing:
    match field.sort:
        case "tint" if field.is_drawn(value):
            return replace(drawing, ground=mixed(drawing.ground, field.colours[value], TINTED))
        case "shape" if field.is_drawn(value):
            return replace(drawing, objects=(*drawing.objects, field.pictures[value]))
        case "edge" if value > 0:
            return replace(drawing, edge=field.colours[value - 1])
        case "bar" if value > 0 and bars.index(field) < len(BARS):
            return replace(drawing, bars=(*drawing.bars, (bars.index(field), value)))
        case _:
            return drawing


def draw_figures(look: Look, values: Values, heading: np.ndarray, held: np.ndarray) -> list[Figure]:
    """Returns how each agent is drawn in a state."""
    colours = look.agent_colours(values)
    plain = [Figure(number, colour, "agent", int(heading[number]), bool(held[number])) for number, colour in enumerate(colours)]
    return _looking(plain, "agent", look.rules, look.carried, values)


def draw_movers(herd: HerdLook, values: Values) -> list[Figure]:
    """Returns how each mover of a sort is drawn in a state; it faces its heading."""
    plain = [Figure(None, herd.colour, herd.sprite, int(heading)) for heading in values[f"{herd.name}_heading"]]
    return _looking(plain, herd.name, herd.rules, herd.carried, values)


def _looking(plain: list[Figure], prefix: str, rules: tuple[Rule, ...], carried: tuple[FieldLook, ...], values: Values) -> list[Figure]:
    """Returns figures after the looks that apply to each, with badges for what it carries. `prefix`: of the attributes of their fields."""
    applied = [rule.applies(prefix, values, len(plain)) for rule in rules]
    figures = []
    for number, figure in enumerate(plain):
        own = [rule for rule, applies in zip(rules, applied, strict=True) if applies[number]]
        read = frozenset().union(*(rule.reads for rule in own))
        badges = [rule.badge for rule in own if rule.badge is not None]
        badges += [picture for field in carried if field.name not in read for picture in _carried(field, values[field.attribute][number])]
        figure = replace(figure, badges=tuple(dict.fromkeys(badges))[:CORNERS])
        for rule in own:
            figure = replace(figure, sprite=rule.sprite or figure.sprite, colour=rule.colour or figure.colour)
        figures.append(figure)
    return figures


def _carried(field: FieldLook, value: np.ndarray) -> list[Picture]:
    """Returns the pictures of what an agent has of a field: of a word that is not its first one, of numbers other than 0."""
    if field.holds == "word":
        return [] if int(value) == field.start else [field.pictures[int(value)]]
    return [picture for picture, amount in zip(field.pictures, np.reshape(value, -1), strict=True) if amount != 0]

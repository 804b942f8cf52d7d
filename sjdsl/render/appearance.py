"""The appearance of a board at one moment, for everything that shows one: what is in each cell, which are marked, who stands where.

A cell or an agent shows what the `look`s that apply say, and then those fields that agents see and none of these looks reads.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from sjdsl.render.colours import COVERING, FILLING, SPRITES, Colour, mixed
from sjdsl.render.look import BADGES, FieldLook, KindLook, Look, Rule, Values
from sjdsl.render.moment import Snapshot
from sjdsl.render.usual import Picture
from sjdsl.runtime.actions import DIRECTIONS

BAR_STEPS = 8
TINTED = 0.45
BADGES_OF_CELL = 8  # that have room: in the corners, then between them
FLASH: Colour = (255, 236, 110)
Cell = tuple[int, int]  # row, column
Key = tuple[
    int, ...
]  # a number for each field: a word's, an agent's and 1, eighths of a bar; 0 or 1 for each rule: whether it applies


@dataclass(frozen=True)
class Drawing:
    """A cell. body: what it is; objects: what is there, side by side; badges: around them; bars: place, of four round the cell and so on, eighths.

    edge: in the colour of its owner; inner: inside it, those of further owners, None for nobody.
    """

    ground: Colour
    body: Picture | None = None
    objects: tuple[Picture, ...] = ()
    badges: tuple[Picture, ...] = ()
    edge: Colour | None = None
    bars: tuple[tuple[int, int], ...] = ()
    inner: tuple[Colour | None, ...] = ()


@dataclass(frozen=True)
class Figure:
    """An agent, or without a number a mover.

    heading: 0 north, 1 east, 2 south, 3 west; held: it can only stay; badges: what it carries, at most two.
    """

    number: int | None
    colour: Colour
    sprite: str = "agent"
    heading: int = 0
    held: bool = False
    badges: tuple[Picture, ...] = ()


@dataclass(frozen=True)
class Beam:
    """A marked cell. fill: the colour of who has marked it; edge: of the phase; sides: north, east, south and west, where the beam ends."""

    fill: Colour
    edge: Colour
    sides: tuple[bool, bool, bool, bool]


@dataclass(frozen=True)
class Appearance:
    """A board, from the bottom up: each cell, and what is over the cells.

    drawings: those that occur; cells: `[H, W]` int, the number of each cell's; figures: with row and column, beams, flashes and who is on
    the map, each over those before.
    """

    drawings: tuple[Drawing, ...]
    cells: np.ndarray
    figures: tuple[tuple[Figure | Beam, int, int], ...]

    def things(self) -> list[set[Picture]]:
        """Returns what stands in the cells of each drawing."""
        return [
            {*d.objects, *d.badges, *([d.body] if d.body is not None else [])}
            for d in self.drawings
        ]


def appearance_of(
    look: Look, snapshot: Snapshot, actions: Sequence[int] = (), before: Snapshot | None = None
) -> Appearance:
    """Returns what is seen of a board.

    Args:
      actions: number of each agent's action in the last step, which say whose beam is whose; unknown without them.
      before: the moment before; what was taken, cleaned or hit since then flashes. None, or another moment: nothing flashes.
    """
    ground = _ground(look, snapshot)
    beams = tuple(_beams(look, snapshot, actions))
    flash = Figure(None, FLASH, "flash")
    struck = (
        ()
        if before is None or before.step + 1 != snapshot.step
        else _struck(look, ground, snapshot, before)
    )
    figures = draw_figures(look, snapshot)
    standing = ((figures[sort][number], row, col) for sort, number, row, col in snapshot.standing())
    return Appearance(
        ground.drawings,
        ground.cells,
        (*beams, *((flash, row, col) for row, col in sorted(struck)), *standing),
    )


def _ground(look: Look, snapshot: Snapshot) -> Appearance:
    """Returns the cells alone."""
    drawings: list[Drawing] = []
    cells = np.zeros((look.height, look.width), int)
    for kind in look.kinds:
        keys, key_of = cell_keys(kind, snapshot.values)
        cells[kind.rows, kind.cols] = len(drawings) + key_of
        drawings += [draw_cell(kind, key, snapshot.step > 0) for key in keys]
    return Appearance(tuple(drawings), cells, ())


def _beams(
    look: Look, snapshot: Snapshot, actions: Sequence[int]
) -> Iterator[tuple[Beam, int, int]]:
    """Yields the marked cells, each in the colour of the agent nearest behind it of those whose action marks in this phase."""
    marked = [(marked_cells(snapshot, label), label, edge) for label, edge in look.marks]
    colours = (
        [figure.colour for figure in draw_figures(look, snapshot)["agent"]]
        if any(cells for cells, _, _ in marked)
        else []
    )
    for cells, label, edge in marked:
        acted = [
            not actions or not look.acting[label] or actions[agent] in look.acting[label]
            for agent in range(look.num_agents)
        ]
        agents = [
            agent for agent in range(look.num_agents) if acted[agent] and snapshot.row[agent] >= 0
        ]
        owner: dict[Cell, int] = {}
        for row, col in cells:
            away = [_beam_distance(snapshot, agent, row, col) for agent in agents]
            owner[row, col] = agents[away.index(min(away))] if away else -1
        for (row, col), agent in owner.items():
            sides = tuple(
                owner.get((row + down, col + right)) != agent for down, right in DIRECTIONS
            )
            yield Beam(colours[agent] if agent >= 0 else edge, edge, sides), row, col  # type: ignore[arg-type]


def _beam_distance(snapshot: Snapshot, agent: int, row: int, col: int) -> tuple[bool, int]:
    """Returns how far a cell is from an agent, as a key to compare agents by: first whether it lies behind, then the steps."""
    down, right = row - int(snapshot.row[agent]), col - int(snapshot.col[agent])
    facing = DIRECTIONS[int(snapshot.heading[agent])]
    return down * facing[0] + right * facing[1] < 0, abs(down) + abs(right)


def _struck(look: Look, ground: Appearance, snapshot: Snapshot, before: Snapshot) -> set[Cell]:
    """Returns the cells to flash: where an object is gone from under an agent or a mark, and where an agent or a mover was hit or removed."""
    was = _ground(look, before)
    here, there = _places(snapshot), _places(before)
    reached = {cell for label, _ in look.marks for cell in marked_cells(snapshot, label)} | {
        at for at in here["agent"] if at is not None
    }
    earlier, now = was.things(), ground.things()
    lost = {
        (row, col)
        for row, col in reached
        if any(
            p.sprite != "floor"
            for p in earlier[int(was.cells[row, col])] - now[int(ground.cells[row, col])]
        )
    }
    held = zip(snapshot.held.tolist(), before.held.tolist(), here["agent"], strict=True)
    lost |= {
        at for now_held, held_before, at in held if at is not None and now_held and not held_before
    }
    for sort, places in there.items():
        for at, then in zip(here[sort], places, strict=True):
            if then is not None and (at is None or _distance(look, at, then) > 1):
                lost.add(then)
    return lost


def _distance(look: Look, first: Cell, second: Cell) -> int:
    """Returns how many steps apart two cells are, across the edges of the map if that is shorter."""
    down, right = abs(first[0] - second[0]), abs(first[1] - second[1])
    return min(down, look.height - down) + min(right, look.width - right)


def _places(snapshot: Snapshot) -> dict[str, list[Cell | None]]:
    """Returns row and column of each agent and mover, None of those that are away, by their sorts."""
    sorts = {"agent": (snapshot.row, snapshot.col), **snapshot.movers}
    return {
        sort: [
            (row, col) if row >= 0 else None
            for row, col in zip(rows.tolist(), cols.tolist(), strict=True)
        ]
        for sort, (rows, cols) in sorts.items()
    }


def marked_cells(snapshot: Snapshot, label: str) -> list[Cell]:
    """Returns row and column of the cells that a phase has marked."""
    rows, cols = np.nonzero(snapshot.marks[label])
    return list(zip(rows.tolist(), cols.tolist(), strict=True))


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
            counts = (
                np.bitwise_count(values).reshape(len(values), -1).sum(axis=1)
            )  # large sets are kept in several numbers
        case "agent":
            return values.astype(int) + 1
        case _:
            counts = values.reshape(len(values), -1).sum(axis=1)
    return np.asarray(np.clip(np.ceil(counts / field.full * BAR_STEPS), 0, BAR_STEPS), int)


@lru_cache(maxsize=4096)
def draw_cell(kind: KindLook, key: Key, begun: bool = False) -> Drawing:
    """Returns what is drawn in a cell of a kind in one of its states; after the first step, `begun`, no mark of a starting place."""
    applied = [
        rule for rule, applies in zip(kind.rules, key[len(kind.fields) :], strict=True) if applies
    ]
    ground, body = kind.ground, None if begun and kind.starting else kind.body
    standing: Picture | None = None  # on a body that fills the cell
    for (
        rule
    ) in applied:  # the last one that speaks of body or ground counts, and all that speak of badges
        if rule.sprite is not None:
            picture = Picture(rule.sprite, rule.colour or SPRITES[rule.sprite])
            is_on = picture.sprite not in FILLING and body is not None and body.sprite in FILLING
            body, standing = (body, picture) if is_on else (picture, None)
        elif rule.colour is not None:
            ground = rule.colour
            body = filled(body, rule.colour)
    if body == Picture("floor", ground):  # a mark in the colour of its ground is not seen
        body = None
    badges = tuple(dict.fromkeys(rule.badge for rule in applied if rule.badge is not None))[
        :BADGES_OF_CELL
    ]
    read = frozenset().union(*(rule.reads for rule in applied))
    objects: list[Picture] = []
    edges: list[Colour | None] = []
    bars: list[tuple[int, int]] = []
    places = {
        field.name: place
        for place, field in enumerate(field for field in kind.fields if field.sort == "bar")
    }
    for field, value in zip(kind.fields, key, strict=False):
        if field.sort == "edge":
            is_owned = value > 0 and field.name not in read
            edges.append(field.colours[value - 1] if is_owned else None)
        if field.name in read:
            continue
        match field.sort:
            case "tint" if field.is_drawn(value):
                ground = mixed(ground, field.colours[value], TINTED)
                body = filled(
                    body, None if body is None else mixed(body.colour, field.colours[value], TINTED)
                )
            case "shape" if field.is_drawn(value):
                objects.append(field.pictures[value])
            case "bar" if value > 0:
                bars.append((places[field.name], value))
    if standing is not None or (
        body is not None and body.sprite not in FILLING
    ):  # a tree with an apple, not an apple over a tree
        objects, badges = (
            [standing] if standing is not None else [],
            (*objects, *badges)[:BADGES_OF_CELL],
        )
    edge, *inner = edges or [None]
    return Drawing(
        ground, body, tuple(objects), badges, edge, tuple(bars), tuple(inner) if any(inner) else ()
    )


def filled(body: Picture | None, colour: Colour | None) -> Picture | None:
    """Returns a body in a colour if it covers the ground, whose colour nobody would see."""
    return (
        Picture(body.sprite, colour)
        if body is not None and colour is not None and body.sprite in COVERING
        else body
    )


def draw_figures(look: Look, snapshot: Snapshot) -> dict[str, list[Figure]]:
    """Returns how each agent is drawn, and, by their sorts, each mover; those that are away among them."""
    values = snapshot.values
    agents = zip(
        look.agent_colours(values), snapshot.heading.tolist(), snapshot.held.tolist(), strict=True
    )
    plain = [
        Figure(number, colour, "agent", heading, held)
        for number, (colour, heading, held) in enumerate(agents)
    ]
    found = {"agent": _looking("agent", plain, look.rules, look.carried, values)}
    for herd in look.herds:  # movers face their heading
        plain = [
            Figure(None, herd.colour, herd.sprite, int(heading))
            for heading in values[f"{herd.name}_heading"]
        ]
        found[herd.name] = _looking(herd.name, plain, herd.rules, herd.carried, values)
    return found


def held_entries(look: Look, snapshot: Snapshot, agent: int) -> list[tuple[Picture, float]]:
    """Returns how much an agent has of each thing that it can have several of, row by row; nothing where agents have no row of numbers."""
    return [
        entry
        for row in look.held
        for entry in zip(row.pictures, snapshot.values[row.attribute][agent].tolist(), strict=True)
    ]


def _looking(
    prefix: str,
    plain: list[Figure],
    rules: tuple[Rule, ...],
    carried: tuple[FieldLook, ...],
    values: Values,
) -> list[Figure]:
    """Returns figures after the looks that apply to each, with badges for what it carries. `prefix`: of the attributes of their fields."""
    applied = [rule.applies(prefix, values, len(plain)) for rule in rules]
    figures = []
    for number, figure in enumerate(plain):
        own = [rule for rule, applies in zip(rules, applied, strict=True) if applies[number]]
        for rule in own:
            figure = ruled(figure, rule)
        read = frozenset().union(*(rule.reads for rule in own))
        words = [
            (field, int(values[field.attribute][number]))
            for field in carried
            if field.name not in read
        ]
        said = [field.pictures[word] for field, word in words if field.is_carried(word)]
        figures.append(
            replace(figure, badges=tuple(dict.fromkeys([*figure.badges, *said]))[:BADGES])
        )
    return figures


def ruled(figure: Figure, rule: Rule) -> Figure:
    """Returns a figure after a `look` that applies to it."""
    badges = figure.badges if rule.badge is None else (*figure.badges, rule.badge)
    return replace(
        figure,
        sprite=rule.sprite or figure.sprite,
        colour=rule.colour or figure.colour,
        badges=badges,
    )

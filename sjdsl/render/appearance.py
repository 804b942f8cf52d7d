"""What a board looks like at one moment: its cells, the marks on them, the agents and movers.

Pictures, films, pages and the terminal are all drawn from it. A cell or an agent shows what the
`look`s that apply say, then the fields that agents see and that none of these looks reads.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial

import numpy as np

from sjdsl.render.colours import COVERING, FILLING, Colour, mixed
from sjdsl.render.look import BADGES, FieldLook, KindLook, Look, Rule, Values
from sjdsl.render.moment import Snapshot
from sjdsl.render.usual import Picture
from sjdsl.runtime.actions import DIRECTIONS

BAR_STEPS = 8
TINTED = 0.45  # share of the tint in a colour
BADGES_OF_CELL = 8  # as many as have room: in the corners, then between them
FLASH: Colour = (255, 236, 110)
NOBODY = -1
Cell = tuple[int, int]  # row, column

# The state of a cell, as far as it is drawn. A number for each field: that of its enum value, its
# agent + 1 or the eighths of its bar; then for each `look` whether it applies, 0 or 1.
Key = tuple[int, ...]


@dataclass(frozen=True)
class Drawing:
    """A cell, from the ground up.

    body: the sprite that stands for the whole cell; objects: sprites side by side; badges: small
    sprites around them.
    edge: a frame in the colour of the cell's owner; inner: frames inside it for more owners, None
    where nobody owns it.
    bars: (number of the side that the bar lies along, length in eighths); after the four sides come
    four places further in, and so on.
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
    """An agent, or a mover, which has no number.

    heading: 0 north, 1 east, 2 south, 3 west; held: whether it can only stay; badges: what it
    carries, at most two.
    """

    number: int | None
    colour: Colour
    sprite: str = "agent"
    heading: int = 0
    held: bool = False
    badges: tuple[Picture, ...] = ()


@dataclass(frozen=True)
class Beam:
    """A marked cell.

    fill: the colour of the agent that marked it; edge: the colour of the phase; sides: whether the
    beam ends at the north, east, south and west side.
    """

    fill: Colour
    edge: Colour
    sides: tuple[bool, bool, bool, bool]


@dataclass(frozen=True)
class Appearance:
    """A board.

    drawings: each different cell once; cells: `[H, W]` int, indices into `drawings`.
    figures: (figure, row, column) in the order of drawing: beams, flashes, agents, movers.
    """

    drawings: tuple[Drawing, ...]
    cells: np.ndarray
    figures: tuple[tuple[Figure | Beam, int, int], ...]


def appearance_of(
    look: Look, snapshot: Snapshot, actions: Sequence[int] = (), before: Snapshot | None = None
) -> Appearance:
    """Returns what a board looks like.

    Args:
      actions: the number of each agent's action in the last step. They tell whose beam is whose;
        without them, any agent may have marked a cell.
      before: the moment before. What was taken, cleaned or hit since then flashes; nothing flashes
        without it, or if it isn't the moment one step before.
    """
    ground = _draw_cells(look, snapshot)
    bodies = draw_figures(look, snapshot)
    figures: list[tuple[Figure | Beam, int, int]] = []
    figures += _beams(look, snapshot, actions, bodies["agent"])
    if before is not None and before.step + 1 == snapshot.step:
        flash = Figure(None, FLASH, "flash")
        for row, col in sorted(_flashing_cells(look, ground, snapshot, before)):
            figures.append((flash, row, col))
    for name, number, row, col in snapshot.standing():
        figures.append((bodies[name][number], row, col))
    return replace(ground, figures=tuple(figures))


def _draw_cells(look: Look, snapshot: Snapshot) -> Appearance:
    """Returns the board without agents, movers, beams and flashes."""
    drawings: list[Drawing] = []
    cells = np.zeros((look.height, look.width), int)
    for kind in look.kinds:
        keys, key_of_cell = cell_keys(kind, snapshot.values)
        cells[kind.rows, kind.cols] = len(drawings) + key_of_cell
        drawings += [draw_cell(kind, key, snapshot.step > 0) for key in keys]
    return Appearance(tuple(drawings), cells, ())


def _beams(
    look: Look, snapshot: Snapshot, actions: Sequence[int], figures: Sequence[Figure]
) -> Iterator[tuple[Beam, int, int]]:
    """Yields the marked cells, with row and column.

    The state doesn't say who marked a cell. It has the colour of the nearest agent that doesn't
    face away from it, among those whose action marks in this phase.

    figures: the agents.
    """
    for label, edge in look.marks:
        marking = look.marking_actions[label]
        agents = []
        for agent in range(look.num_agents):
            may_mark = not actions or not marking or actions[agent] in marking
            if may_mark and snapshot.row[agent] >= 0:
                agents.append(agent)
        owners: dict[Cell, int] = {}
        for cell in marked_cells(snapshot, label):
            distance = partial(_beam_distance, snapshot, cell)
            owners[cell] = min(agents, key=distance, default=NOBODY)
        for (row, col), owner in owners.items():
            beside = [owners.get((row + down, col + right)) for down, right in DIRECTIONS]
            north, east, south, west = (other != owner for other in beside)
            fill = edge if owner == NOBODY else figures[owner].colour
            yield Beam(fill, edge, (north, east, south, west)), row, col


def _beam_distance(snapshot: Snapshot, cell: Cell, agent: int) -> tuple[bool, int]:
    """Returns how far a cell is from an agent, to compare: whether it lies behind, then steps."""
    down = cell[0] - int(snapshot.row[agent])
    right = cell[1] - int(snapshot.col[agent])
    facing_down, facing_right = DIRECTIONS[int(snapshot.heading[agent])]
    is_behind = down * facing_down + right * facing_right < 0
    return is_behind, abs(down) + abs(right)


def _flashing_cells(
    look: Look, ground: Appearance, snapshot: Snapshot, before: Snapshot
) -> set[Cell]:
    """Returns the cells where something was taken, cleaned or hit in the last step.

    That is where an object has gone from under an agent or a mark, where an agent is held since
    that step, and from where an agent or a mover was sent away.
    """
    positions = _positions(snapshot)
    earlier_positions = _positions(before)
    earlier_ground = _draw_cells(look, before)
    touched = {cell for cell in positions["agent"] if cell is not None}
    for label, _ in look.marks:
        touched |= {*marked_cells(snapshot, label)}
    flashing: set[Cell] = set()
    for cell in touched:
        gone = _pictures_in(earlier_ground, cell) - _pictures_in(ground, cell)
        if any(picture.sprite != "floor" for picture in gone):
            flashing.add(cell)
    for agent, position in enumerate(positions["agent"]):
        if position is not None and snapshot.held[agent] and not before.held[agent]:
            flashing.add(position)
    for name, cells in earlier_positions.items():
        for earlier, position in zip(cells, positions[name], strict=True):
            if earlier is not None and (position is None or _steps(look, earlier, position) > 1):
                flashing.add(earlier)
    return flashing


def _pictures_in(ground: Appearance, cell: Cell) -> set[Picture]:
    """Returns the sprites in a cell."""
    drawing = ground.drawings[int(ground.cells[cell])]
    body = set() if drawing.body is None else {drawing.body}
    return body | {*drawing.objects, *drawing.badges}


def _steps(look: Look, first: Cell, second: Cell) -> int:
    """Returns the steps between two cells, across the edges of the map if that is shorter."""
    down = abs(first[0] - second[0])
    right = abs(first[1] - second[1])
    return min(down, look.height - down) + min(right, look.width - right)


def _positions(snapshot: Snapshot) -> dict[str, list[Cell | None]]:
    """Returns row and column of each agent and each mover, by type; None if it is away."""
    positions: dict[str, list[Cell | None]] = {"agent": [None] * len(snapshot.row)}
    for name, (rows, _) in snapshot.movers.items():
        positions[name] = [None] * len(rows)
    for name, number, row, col in snapshot.standing():
        positions[name][number] = (row, col)
    return positions


def marked_cells(snapshot: Snapshot, label: str) -> list[Cell]:
    """Returns row and column of the cells that a phase has marked."""
    rows, cols = np.nonzero(snapshot.marks[label])
    return list(zip(rows.tolist(), cols.tolist(), strict=True))


def cell_keys(kind: KindLook, values: Values) -> tuple[list[Key], np.ndarray]:
    """Returns the different keys among the cells of a kind, and each cell's index into them, `[S]`.

    Args:
      values: attribute of the state -> array.
    """
    count = len(kind.rows)
    columns = [shown_values(field, values[field.attribute]) for field in kind.fields]
    columns += [rule.applies(kind.name, values, count).astype(int) for rule in kind.rules]
    if not columns:
        return [()], np.zeros(count, int)
    keys, key_of_cell = np.unique(np.stack(columns, axis=1), axis=0, return_inverse=True)
    return [tuple(key) for key in keys.tolist()], key_of_cell.reshape(-1)


def shown_values(field: FieldLook, values: np.ndarray) -> np.ndarray:
    """Returns a field's number in the key of each cell, `[S]` int.

    That is the number of its enum value, its agent + 1, or the eighths of its bar, rounded up.
    """
    match field.holds:
        case "word":
            return values.astype(int)
        case "agent":
            return values.astype(int) + 1
        case "agents":  # a large set is kept as several numbers
            counts = np.bitwise_count(values).reshape(len(values), -1).sum(axis=1)
        case "number":
            counts = values.reshape(len(values), -1).sum(axis=1)
    return np.asarray(np.clip(np.ceil(counts / field.full * BAR_STEPS), 0, BAR_STEPS), int)


@lru_cache(maxsize=4096)
def draw_cell(kind: KindLook, key: Key, begun: bool = False) -> Drawing:
    """Returns how a cell of a kind is drawn: its looks that apply, then fields that none reads.

    begun: whether the first step is over, so that marks of starting places are left out.
    """
    values = key[: len(kind.fields)]
    applies = key[len(kind.fields) :]
    rules = [rule for rule, is_applied in zip(kind.rules, applies, strict=True) if is_applied]
    ground, body, standing = _apply_sprites(kind, rules, begun)
    fields_in_rules = {name for rule in rules for name in rule.reads}
    objects: list[Picture] = []
    edges: list[Colour | None] = []
    bars: list[tuple[int, int]] = []
    num_bars = 0  # each has its side, also if it is empty
    for field, value in zip(kind.fields, values, strict=True):
        is_read = field.name in fields_in_rules
        match field.drawn_as:
            case "edge":
                edges.append(field.colours[value - 1] if value > 0 and not is_read else None)
            case "bar":
                if value > 0 and not is_read:
                    bars.append((num_bars, value))
                num_bars += 1
            case "tint" if not is_read and field.is_drawn(value):
                tint = field.colours[value]
                ground = mixed(ground, tint, TINTED)
                if body is not None:
                    body = _tint_body(body, mixed(body.colour, tint, TINTED))
            case "shape" if not is_read and field.is_drawn(value):
                objects.append(field.pictures[value])
    badges = list(dict.fromkeys(rule.badge for rule in rules if rule.badge is not None))
    if standing is not None or (body is not None and not _fills_cell(body)):
        # A tree with an apple, not an apple over a tree.
        badges = [*objects, *badges]
        objects = [] if standing is None else [standing]
    edge, *inner = edges or [None]
    return Drawing(
        ground=ground,
        body=body,
        objects=tuple(objects),
        badges=tuple(badges[:BADGES_OF_CELL]),
        edge=edge,
        bars=tuple(bars),
        inner=tuple(inner) if any(inner) else (),
    )


def _apply_sprites(
    kind: KindLook, rules: Sequence[Rule], begun: bool
) -> tuple[Colour, Picture | None, Picture | None]:
    """Returns the ground, the body and what stands on a body that fills the cell, by the looks.

    Of the looks with a sprite or a colour the last one counts.
    """
    ground = kind.ground
    body = None if begun and kind.starting else kind.body
    standing: Picture | None = None
    for rule in rules:
        picture = rule.picture
        if picture is None:
            if rule.colour is not None:
                ground = rule.colour
                body = _tint_body(body, rule.colour)
        elif _fills_cell(body) and not _fills_cell(picture):
            standing = picture
        else:
            body = picture
            standing = None
    if body == Picture("floor", ground):  # a mark in the colour of its ground can't be seen
        body = None
    return ground, body, standing


def _fills_cell(body: Picture | None) -> bool:
    return body is not None and body.sprite in FILLING


def _tint_body(body: Picture | None, colour: Colour) -> Picture | None:
    """Returns the body in a colour if it hides the ground, whose colour nobody would see."""
    if body is not None and body.sprite in COVERING:
        return Picture(body.sprite, colour)
    return body


def draw_figures(look: Look, snapshot: Snapshot) -> dict[str, list[Figure]]:
    """Returns the agents, `agent`, and the movers by type, those that are away among them."""
    values = snapshot.values
    headings = snapshot.heading.tolist()
    held = snapshot.held.tolist()
    agents = [
        Figure(number, colour, "agent", headings[number], held[number])
        for number, colour in enumerate(look.agent_colours(values))
    ]
    figures = {"agent": _apply_looks(agents, "agent", look.rules, look.carried, values)}
    for herd in look.herds:
        movers = [
            Figure(None, herd.colour, herd.sprite, heading)
            for heading in values[f"{herd.name}_heading"].tolist()
        ]
        figures[herd.name] = _apply_looks(movers, herd.name, herd.rules, herd.carried, values)
    return figures


def possessions_of(look: Look, snapshot: Snapshot, agent: int) -> list[tuple[Picture, float]]:
    """Returns the things that an agent can have, each with the amount that it has."""
    entries: list[tuple[Picture, float]] = []
    for field in look.possessions:
        amounts = snapshot.values[field.attribute][agent].tolist()
        entries += zip(field.pictures, amounts, strict=True)
    return entries


def _apply_looks(
    figures: list[Figure],
    prefix: str,
    rules: tuple[Rule, ...],
    carried: tuple[FieldLook, ...],
    values: Values,
) -> list[Figure]:
    """Returns figures as the looks that apply to each say, with a badge for each thing carried.

    Args:
      prefix: what the names of the figures' attributes in `values` begin with.
    """
    applies = [rule.applies(prefix, values, len(figures)) for rule in rules]
    result = []
    for number, figure in enumerate(figures):
        fields_in_rules: set[str] = set()
        for rule, applies_to in zip(rules, applies, strict=True):
            if applies_to[number]:
                figure = apply_rule(figure, rule)
                fields_in_rules |= rule.reads
        badges = list(figure.badges)
        for field in carried:
            value = int(values[field.attribute][number])
            if field.name not in fields_in_rules and field.is_carried(value):
                badges.append(field.pictures[value])
        distinct = tuple(dict.fromkeys(badges))
        result.append(replace(figure, badges=distinct[:BADGES]))
    return result


def apply_rule(figure: Figure, rule: Rule) -> Figure:
    """Returns a figure as a `look` that applies to it says."""
    badges = figure.badges if rule.badge is None else (*figure.badges, rule.badge)
    return replace(
        figure,
        sprite=rule.sprite or figure.sprite,
        colour=rule.colour or figure.colour,
        badges=badges,
    )

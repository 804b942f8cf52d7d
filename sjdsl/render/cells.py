"""Cells as letters: two characters with an ink and a ground for each cell and agent, for everything that draws boards in a terminal.

All colours are among the 240 that a terminal of 256 colours has besides its own 16, and kinds that look different in a picture differ here.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache

import numpy as np

from sjdsl.render.colours import INK, PAPER, Colour, mixed
from sjdsl.render.drawings import BARS, Drawing, Figure, cell_keys, draw_cell, draw_figures
from sjdsl.render.entries import cell_entries, figure_entries
from sjdsl.render.look import Look
from sjdsl.render.snapshot import Snapshot

ARROWS = "▲▶▼◀"  # north, east, south, west
LEVELS = (0, 95, 135, 175, 215, 255)  # of each of the three colours of the cube
GREYS = tuple(range(8, 239, 10))
STEPS = " ▁▂▃▄▅▆▇█"  # eighths of a bar
MARKED = 0.6
OWN = PAPER  # ground of the agent that a person steers
SIGNS = {
    "wall": "▒▒",
    "water": "≈≈",
    "floor": "··",
    "tree": "♣ ",
    "apple": "● ",
    "mushroom": "♠ ",
    "ore": "◘ ",
    "gem": "♦ ",
    "coin": "$ ",
    "animal": "♞ ",
    "raft": "≡ ",
    "pot": "∪ ",
    "disc": "• ",
    "diamond": "◊ ",
    "square": "■ ",
    "triangle": "△ ",
    "ring": "○ ",
    "cross": "+ ",
    "hexagon": "* ",
    "wedge": "▽ ",
}


@dataclass(frozen=True)
class Cell:
    """Two characters. bold: an agent."""

    text: str
    ink: Colour
    ground: Colour
    bold: bool = False


def board_cells(look: Look, snapshot: Snapshot, own: int | None = None) -> list[list[Cell]]:
    """Returns the board of one moment, `[H][W]`.

    Args:
      own: the agent that a person steers; it stands out from all others.
    """
    grounds = _grounds(look)
    board: list[list[Cell]] = [[Cell("  ", terminal_colour(INK), PAPER)] * look.width for _ in range(look.height)]
    for kind in look.kinds:
        keys, state_of = cell_keys(kind, snapshot.values)
        cells = [drawn_cell(draw_cell(kind, key), grounds) for key in keys]
        for row, col, state in zip(kind.rows, kind.cols, state_of, strict=True):
            board[row][col] = cells[state]
    for _, attribute, colour in look.marks:
        for row, col in np.argwhere(snapshot.marked(attribute, look)):
            under = board[row][col]
            board[row][col] = Cell(under.text, under.ink, terminal_colour(mixed(under.ground, colour, MARKED)))
    for figure in draw_figures(look, snapshot.values, snapshot.heading, snapshot.held):
        row, col = int(snapshot.row[figure.number]), int(snapshot.col[figure.number])
        if 0 <= row < look.height and 0 <= col < look.width:
            board[row][col] = figure_cell(figure, own)
    return board


def legend_cells(look: Look) -> Iterator[tuple[Cell, str]]:
    """Yields everything that can be on the board with its text: kinds, words, beams, roles."""
    grounds = _grounds(look)
    for drawing, text in cell_entries(look):
        yield drawn_cell(drawing, grounds), text
    for label, _, colour in look.marks:
        yield Cell("  ", terminal_colour(INK), terminal_colour(mixed(look.kinds[0].ground, colour, MARKED))), label
    for figure, text in figure_entries(look):
        if not figure.badges:
            yield figure_cell(figure), text


def drawn_cell(drawing: Drawing, grounds: dict[Colour, Colour]) -> Cell:
    """Returns the letters of a cell: of what is there before what it is, and of an owner's edge the colour."""
    things = (*drawing.objects, *drawing.badges)
    shown = (drawing.body, *things) if drawing.body is not None else things
    ground = grounds.get(drawing.ground) or terminal_colour(drawing.ground)
    if not shown:
        edge = Cell("[]" if drawing.edge else "  ", terminal_colour(drawing.edge or INK), ground)
        return _bars(drawing, ground) if drawing.bars else edge
    first = things[0] if things else shown[0]
    text = SIGNS[first.sprite]
    if len(shown) > 1 and text.endswith(" "):
        other = things[1] if len(things) > 1 else shown[0]
        text = text[0] + SIGNS[other.sprite][0]
    elif drawing.edge is not None:
        return Cell(f"{text[0]}]", terminal_colour(drawing.edge), ground)
    return Cell(text, _ink(first.sprite, first.colour, ground), ground)


def _bars(drawing: Drawing, ground: Colour) -> Cell:
    """Returns the letters of a cell that shows numbers alone: a level for each of the first two."""
    levels = dict(drawing.bars)
    text = "".join(STEPS[levels.get(place, 0)] for place in (0, 1))
    first = min(levels)
    return Cell(text if text.strip() else f"+{first}", terminal_colour(BARS[first]), ground)


def figure_cell(figure: Figure, own: int | None = None) -> Cell:
    """Returns an arrow with the last digit of the agent's number on its colour; of the own agent, the other way round."""
    text = f"{ARROWS[figure.heading]}{figure.number % 10}"
    colour = terminal_colour(mixed(figure.colour, PAPER, 0.5) if figure.held else figure.colour)
    if figure.number == own:
        return Cell(text, terminal_colour(mixed(figure.colour, INK, 0.35)), OWN, bold=True)
    ink = PAPER if sum(w * c for w, c in zip((0.3, 0.59, 0.11), colour, strict=True)) < 140 else (8, 8, 8)
    return Cell(text, ink, colour, bold=True)


@cache
def terminal_colour(colour: Colour) -> Colour:
    """Returns the nearest colour that a terminal of 256 colours shows exactly: of its cube of 216, or one of its 24 greys."""
    cube = tuple(min(LEVELS, key=lambda level, part=part: abs(level - part)) for part in colour)
    grey = min(GREYS, key=lambda level: abs(level - sum(colour) / 3))
    near = min(cube, (grey, grey, grey), key=lambda found: sum((a - b) ** 2 for a, b in zip(found, colour, strict=True)))
    return near[0], near[1], near[2]


def _ink(sprite: str, colour: Colour, ground: Colour) -> Colour:
    """Returns a sprite's colour, lighter or darker where it would not be seen; a mark on the floor is faint, walls and water are seen by their pattern."""
    if sprite == "floor":
        return terminal_colour(mixed(colour, ground, 0.4))
    if sprite in ("wall", "water"):
        return terminal_colour(mixed(ground, PAPER if sum(ground) < 384 else INK, 0.3))
    ink = terminal_colour(colour)
    if sum(abs(a - b) for a, b in zip(ink, ground, strict=True)) < 120:
        return terminal_colour(mixed(colour, INK if sum(ground) > 384 else PAPER, 0.55))
    return ink


def _grounds(look: Look) -> dict[Colour, Colour]:
    """Returns for the ground of each kind a terminal's colour; different ones stay different, darker if need be."""
    found: dict[Colour, Colour] = {}
    for kind in look.kinds:
        if kind.ground in found:
            continue
        shown = (terminal_colour(mixed(kind.ground, INK, share / 20)) for share in range(20))
        found[kind.ground] = next((c for c in shown if c not in found.values()), terminal_colour(kind.ground))
    return found

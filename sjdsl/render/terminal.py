"""Boards in a terminal: two letters a cell, with arrows for agents."""

from io import StringIO

from rich.console import Console
from rich.style import Style
from rich.text import Text

from sjdsl.render.cells import Cell, board_cells, legend_cells
from sjdsl.render.colours import Colour
from sjdsl.render.look import Look
from sjdsl.render.snapshot import Snapshot


def board_text(look: Look, snapshot: Snapshot, own: int | None = None) -> Text:
    """Returns the board of one moment, a line for each row of the map.

    Args:
      own: the agent that a person steers; it stands out from all others.
    """
    text = Text()
    for row in board_cells(look, snapshot, own):
        for cell in row:
            text.append(cell.text, cell_style(cell))
        text.append("\n")
    return text


def legend_text(look: Look) -> Text:
    """Returns what is what: each thing that can be on the board, with its name."""
    text = Text()
    for number, (cell, name) in enumerate(legend_cells(look)):
        text.append("   " if number else "")
        text.append(cell.text, cell_style(cell))
        text.append(f"\u00a0{name}".replace(" ", "\u00a0"))
    return text


def board_letters(look: Look, snapshot: Snapshot) -> str:
    """Returns the board with the codes that colour it in any terminal of 256 colours."""
    console = Console(file=StringIO(), force_terminal=True, color_system="256", width=2 * look.width + 1)
    with console.capture() as shown:
        console.print(board_text(look, snapshot), end="", no_wrap=True)
    return shown.get()


def cell_style(cell: Cell) -> Style:
    """Returns the style of a cell's letters."""
    return Style(color=_name(cell.ink), bgcolor=_name(cell.ground), bold=cell.bold)


def _name(colour: Colour) -> str:
    return "rgb({},{},{})".format(*colour)

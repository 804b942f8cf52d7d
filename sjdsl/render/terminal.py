"""Boards in a terminal: two letters a cell, coloured as in pictures, with arrows for agents."""

from dataclasses import replace
from io import StringIO

from rich.console import Console
from rich.style import Style
from rich.text import Text

from sjdsl.render.board import Tiles, draw_board
from sjdsl.render.colours import INK, Colour
from sjdsl.render.look import Look
from sjdsl.render.snapshot import Snapshot

ARROWS = "▲▶▼◀"  # north, east, south, west
PIXELS = 2  # of a cell's side: a letter shows two of them, one above the other


def board_text(look: Look, snapshot: Snapshot, tiles: Tiles) -> Text:
    """Returns the board of one moment, a line for each row of the map. `tiles`: as for `draw_board`, and not those of another size."""
    board = draw_board(replace(look, tile=PIXELS, num_agents=0), snapshot, tiles)
    agents = _agents(look, snapshot)
    text = Text()
    for row in range(look.height):
        for col in range(look.width):
            upper, lower = (board[PIXELS * row + line, PIXELS * col : PIXELS * (col + 1)] for line in (0, 1))
            if (row, col) in agents:
                letters, colour = agents[row, col]
                text.append(letters, Style(color=_name(INK), bgcolor=_name(colour), bold=True))
                continue
            for above, below in zip(upper, lower, strict=True):
                text.append("▀", Style(color=_name(tuple(above)), bgcolor=_name(tuple(below))))
        text.append("\n")
    return text


def board_letters(look: Look, snapshot: Snapshot, tiles: Tiles) -> str:
    """Returns the same with the codes that colour it in any terminal of many colours."""
    console = Console(file=StringIO(), force_terminal=True, color_system="truecolor", width=PIXELS * look.width + 1)
    with console.capture() as shown:
        console.print(board_text(look, snapshot, tiles), end="", no_wrap=True)
    return shown.get()


def _agents(look: Look, snapshot: Snapshot) -> dict[tuple[int, int], tuple[str, Colour]]:
    """Returns by cell an arrow with the last digit of the agent's number, and the agent's colour."""
    colours = look.agent_colours(snapshot.values)
    return {
        (int(row), int(col)): (f"{ARROWS[heading]}{number % 10}", colours[number])
        for number, (row, col, heading) in enumerate(zip(snapshot.row, snapshot.col, snapshot.heading, strict=True))
    }


def _name(colour: Colour) -> str:
    return "rgb({},{},{})".format(*(int(part) for part in colour))

"""The map on the screen: two letters a cell, an arrow and a number or character for agents and movers, colours for the cells of beams."""

from io import StringIO

from rich.console import Console
from rich.style import Style
from rich.text import Text

from sjdsl.compiler import ir
from sjdsl.interpreter.board import board_of
from sjdsl.interpreter.state import HEADINGS, Cell, World
from sjdsl.render.colours import Colour
from sjdsl.screen.display import Display
from sjdsl.screen.looks import OWN, ScreenLooks, letter_of
from sjdsl.screen.palette import ink_on

ARROWS = "▲▶▼◀"  # north, east, south, west
WIDTH = 2  # letters of a cell


def board_text(game: ir.Game, looks: ScreenLooks, display: Display, own: int | None = None) -> Text:
    """Returns the map of one moment, a line for each row. `own`: the agent that is steered; it has a colour of its own."""
    world, lines = display.world, []
    agents = {place: number for number, place in enumerate(world.position) if place is not None}
    movers = {place: (sort, n) for sort, herd in world.movers.items() for n, place in enumerate(herd.position) if place is not None}
    beams = {(row, col): looks.marks[name][1] for name, row, col in world.marks if name in looks.marks}
    kind_of = board_of(game).kind_of
    for row in range(len(game.rows)):
        line = Text(no_wrap=True)
        for col in range(len(game.rows[0])):
            place = Cell(row, col)
            if place in agents:
                number = agents[place]
                line.append(*agent_letters(looks, world, number, own, number in display.held))
            elif place in movers:
                line.append(*mover_letters(looks, world, *movers[place]))
            else:
                _append_cell(line, game, looks, world, place, kind_of[place], beams.get((row, col)))
        lines.append(line)
    return Text("\n").join(lines)


def board_letters(game: ir.Game, looks: ScreenLooks, display: Display) -> str:
    """Returns the map with the codes that colour it in any terminal of 256 colours, each row on a line."""
    console = Console(file=StringIO(), force_terminal=True, color_system="256", width=WIDTH * len(game.rows[0]) + 1)
    with console.capture() as shown:
        console.print(board_text(game, looks, display), no_wrap=True)
    return shown.get()


def agent_letters(looks: ScreenLooks, world: World, number: int, own: int | None, held: bool) -> tuple[str, Style]:
    """Returns an agent: an arrow the way it faces, its number, its colour; who can only stay has pale letters."""
    ground = OWN if number == own else looks.agents[number]
    return f"{ARROWS[world.heading[number]]}{letter_of(number)}", Style(
        color=hexadecimal(ink_on(ground)), bgcolor=hexadecimal(ground), bold=not held, dim=held
    )


def mover_letters(looks: ScreenLooks, world: World, sort: str, number: int) -> tuple[str, Style]:
    """Returns a mover: an arrow the way it faces, the character and the colour of its sort."""
    facing = HEADINGS.index(world.movers[sort].fields["heading"][number])
    return f"{ARROWS[facing]}{looks.letters.movers[sort]}", mover_style(looks, sort)


def mover_style(looks: ScreenLooks, sort: str) -> Style:
    ground = looks.movers[sort]
    return Style(color=hexadecimal(ink_on(ground)), bgcolor=hexadecimal(ground))


def _append_cell(line: Text, game: ir.Game, looks: ScreenLooks, world: World, place: Cell, kind: str, beam: Colour | None) -> None:
    number = board_of(game).number[place]
    state = tuple((name, world.cells[kind, name][number]) for name in looks.letters.shown[kind])
    ground, ink = (beam, ink_on(beam)) if beam else looks.tiles[kind, state]
    style = Style(color=hexadecimal(ink), bgcolor=hexadecimal(ground))
    line.append(looks.letters.characters[kind, state], style)
    owner = world.cells[kind, looks.owners[kind]][number] if kind in looks.owners else None
    if owner is not None:
        colour = looks.agents[owner]
        line.append(letter_of(owner), Style(color=hexadecimal(ink_on(colour)), bgcolor=hexadecimal(colour)))
        return
    amount = world.cells[kind, looks.amounts[kind]][number] if kind in looks.amounts else 0
    line.append(" " if not amount else str(amount) if 0 < amount < 10 else "+", style)


def hexadecimal(colour: Colour) -> str:
    """Returns a colour as Rich and Textual read it."""
    return "#{:02x}{:02x}{:02x}".format(*colour)

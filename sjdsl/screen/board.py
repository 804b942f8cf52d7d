"""The map on the screen: two letters a cell, an arrow and a number or character for agents and movers, colours for the cells of beams."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from io import StringIO

import numpy as np
from rich.console import Console
from rich.style import Style
from rich.text import Text

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import kind_named
from sjdsl.interpreter.board import Board, board_of
from sjdsl.interpreter.state import field_value
from sjdsl.interpreter.stored import stored
from sjdsl.render.appearance import Figure, cell_keys, draw_cell, main_colour, standing_figures
from sjdsl.render.colours import Colour, agent_colour, hexadecimal
from sjdsl.render.letters import Letters, State, make_letters
from sjdsl.render.look import KindLook, Look, make_look
from sjdsl.render.moment import Snapshot
from sjdsl.screen.palette import faint_on, ink_on, told_apart

OWN: Colour = (255, 0, 255)  # of the agent that is steered, and of nothing else
NUMBERS = "0123456789abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"
ARROWS = "▲▶▼◀"  # north, east, south, west
WIDTH = 2  # letters of a cell


@dataclass(frozen=True)
class ScreenLooks:
    """How a game looks on the screen; no two colours of the map are alike in a terminal of 256.

    board: the map; look: as in pictures; letters: as `sjdsl trace` has them. tiles: (kind, words of its shown fields) -> colours of the cell and of its letter;
    marks: label of a phase -> colour; bodies: `agent` or a sort of movers, and the colour in pictures -> colour here.
    owners, amounts: by kind, the field whose agent, or whose number, stands beside the letter.
    """

    board: Board
    look: Look
    letters: Letters
    tiles: Mapping[tuple[str, State], tuple[Colour, Colour]]
    marks: Mapping[str, Colour]
    bodies: Mapping[tuple[str, Colour], Colour]
    owners: Mapping[str, str]
    amounts: Mapping[str, str]


def make_screen_looks(game: ir.Game) -> ScreenLooks:
    """Returns how a game looks on the screen: in the colours of its pictures, or those nearest to them that differ."""
    look, letters = make_look(game), make_letters(game)
    kinds = {kind.name: kind for kind in look.kinds}
    drawn = {state: _main_colour(game, kinds[state[0]], letters, state[1]) for state in letters.characters if state[0] in kinds}
    tiles = told_apart([colour for colour, _ in drawn.values()], [OWN])
    marks = told_apart([colour for _, colour in look.marks], [OWN, *tiles])
    owners = {kind.name: f.name for kind in game.kinds for f in reversed(kind.fields) if f.type.kind == "agent" and not f.type.by}
    numbered = [] if look.colour_field is not None and not owners else [agent_colour(number) for number in range(look.num_agents)]
    roles = () if look.colour_field is None else look.colour_field[1]
    wanted = [("agent", colour) for colour in (*numbered, *roles, *(rule.colour for rule in look.rules)) if colour is not None]
    wanted += [
        (herd.name, colour) for herd in look.herds for colour in (herd.colour, *(rule.colour for rule in herd.rules)) if colour is not None
    ]
    wanted = list(dict.fromkeys(wanted))
    bodies = told_apart([colour for _, colour in wanted], [OWN, *tiles, *marks])
    return ScreenLooks(
        board=board_of(game),
        look=look,
        letters=letters,
        tiles={
            state: (tile, ink_on(tile) if stands else faint_on(tile))
            for (state, (_, stands)), tile in zip(drawn.items(), tiles, strict=True)
        },
        marks={label: colour for (label, _), colour in zip(look.marks, marks, strict=True)},
        bodies=dict(zip(wanted, bodies, strict=True)),
        owners=owners,
        amounts={
            kind.name: f.name
            for kind in game.kinds
            for f in reversed(kind.fields)
            if f.type.kind == "int" and not f.type.by and not f.timer
        },
    )


def _main_colour(game: ir.Game, kind: KindLook, letters: Letters, state: State) -> tuple[Colour, bool]:
    """Returns the colour that a picture would show most of in a state of a cell, and whether anything stands there."""
    words = dict(zip((f.name for f in letters.shown[kind.name]), state, strict=True))
    values = {}
    for field in kind_named(game, kind.name).fields:
        held = field_value(field, words.get(field.name, field.start))
        values[f"{kind.name}_{field.name}"] = np.array([stored(held, field.type, game.agents.number)])
    one = replace(kind, rows=np.zeros(1, int), cols=np.zeros(1, int))
    (key,), _ = cell_keys(one, values)
    return main_colour(draw_cell(one, key))


def board_text(looks: ScreenLooks, snapshot: Snapshot, own: int | None = None) -> Text:
    """Returns the map of one moment, a line for each row. `own`: the agent that is steered; it has a colour of its own."""
    shown: dict[tuple[int, int], list[tuple[str, Style]]] = {}
    for cell, kind, number, state in looks.letters.states(looks.board, snapshot):
        ground, ink = looks.tiles[kind, state]
        for label, colour in looks.marks.items():
            if snapshot.marks[label][cell]:
                ground, ink = colour, ink_on(colour)
        style = Style(color=hexadecimal(ink), bgcolor=hexadecimal(ground))
        owner = snapshot.values[f"{kind}_{looks.owners[kind]}"][number] if kind in looks.owners else -1
        amount = snapshot.values[f"{kind}_{looks.amounts[kind]}"][number] if kind in looks.amounts else 0
        beside = (" " if not amount else str(amount) if 0 < amount < 10 else "+", style)
        if owner >= 0:
            beside = (letter_of(owner), inked(looks.bodies["agent", agent_colour(owner)]))
        shown[cell] = [(looks.letters.characters[kind, state], style), beside]
    for sort, figure, row, col in standing_figures(looks.look, snapshot):
        shown[row, col] = [figure_letters(looks, sort, figure, own)]
    rows = range(looks.look.height), range(looks.look.width)
    return Text("\n").join(Text(no_wrap=True).join(Text.assemble(*shown[row, col]) for col in rows[1]) for row in rows[0])


def figure_letters(looks: ScreenLooks, sort: str, figure: Figure, own: int | None = None) -> tuple[str, Style]:
    """Returns an agent or a mover: an arrow the way it faces, the agent's number or the character of the movers, its colour.

    Who can only stay has pale letters.
    """
    letter = looks.letters.movers[sort] if figure.number is None else letter_of(figure.number)
    ground = OWN if own is not None and figure.number == own else looks.bodies[sort, figure.colour]
    style = inked(ground)
    return f"{ARROWS[figure.heading]}{letter}", style if sort != "agent" else style + Style(bold=not figure.held, dim=figure.held)


def letter_of(agent: int) -> str:
    """Returns the one letter that stands for an agent's number: 0 to 9, a for 10, b for 11 and so on."""
    return NUMBERS[agent] if agent < len(NUMBERS) else "+"


def inked(ground: Colour) -> Style:
    """Returns the style of letters that are easy to read on a colour."""
    return Style(color=hexadecimal(ink_on(ground)), bgcolor=hexadecimal(ground))


def board_letters(looks: ScreenLooks, snapshot: Snapshot) -> str:
    """Returns the map with the codes that colour it in any terminal of 256 colours, each row on a line."""
    console = Console(file=StringIO(), force_terminal=True, color_system="256", width=WIDTH * looks.look.width + 1)
    with console.capture() as shown:
        console.print(board_text(looks, snapshot), no_wrap=True)
    return shown.get()

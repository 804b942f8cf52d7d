"""Colours and letters: told apart in a terminal of 256 colours, as Rich makes them there."""

from dataclasses import replace

import numpy as np
import pytest
from rich.color import Color, ColorSystem
from rich.console import Console
from rich.style import Style
from rich.text import Text

from sjdsl.cli.game_file import open_game
from sjdsl.compiler import build, ir
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.interpreter.state import HEADINGS, default_params
from sjdsl.interpreter.step import reset
from sjdsl.interpreter.threefry import Threefry
from sjdsl.library.games_folder import main_games
from sjdsl.render.colours import Colour, agent_colour, hexadecimal, read_colour
from sjdsl.render.moment import snapshot_of
from sjdsl.screen.board import ARROWS, OWN, board_text, make_screen_looks
from sjdsl.screen.palette import TABLE, faint_on, ink_on, oklab, told_apart
from sjdsl.screen.session import Interpreted, Session
from sjdsl.screen.sidebar import legend
from tests.screen.conftest import ORCHARD, Begin


def in_256(colour: Colour) -> int:
    """Returns the number of a colour in a terminal of 256, as Rich converts it."""
    number = Color.parse(hexadecimal(colour)).downgrade(ColorSystem.EIGHT_BIT).number
    assert number is not None
    return number


@pytest.mark.parametrize("game", [*main_games(), "harvest_open crowd"])
def test_what_differs_on_the_map_differs_in_256_colours(game: str) -> None:
    name, *variant = game.split()
    looks = make_screen_looks(build(open_game(name), tuple(variant)).game)
    grounds = [ground for ground, _ in looks.tiles.values()]
    shown = [in_256(colour) for colour in (*grounds, *looks.marks.values(), *looks.bodies.values(), OWN)]
    assert len(set(shown)) == len(shown)
    letters = [looks.letters.characters[state] for state in looks.tiles]
    assert len(set(letters)) == len(letters), "without colours the letters tell"


def test_movers_are_on_the_map_with_an_arrow_and_their_character() -> None:
    game = build(open_game("tests/differential/games/movers.sj")).game
    looks = make_screen_looks(game)
    world = reset(game, default_params(game), Threefry(0, 1))
    text = board_text(looks, snapshot_of(game, world, [0.0] * 3))
    rows = text.plain.split("\n")
    for sort in game.movers:
        herd = world.movers[sort.name]
        for place, heading in zip(herd.position, herd.fields["heading"], strict=True):
            assert place is not None
            assert rows[place.row][2 * place.col : 2 * place.col + 2] == ARROWS[HEADINGS.index(heading)] + sort.glyph
        assert f"{sort.glyph} {sort.name} that faces up" in legend(looks, None).plain
    colours = [in_256(colour) for colour in (*looks.bodies.values(), *(g for g, _ in looks.tiles.values()), OWN)]
    assert len(set(colours)) == len(colours)
    herd = world.movers["cart"]
    gone = replace(world, movers=world.movers | {"cart": replace(herd, position=[None])})
    assert "c" not in board_text(looks, snapshot_of(game, gone, [0.0] * 3)).plain, "who is away is not drawn"


def test_the_table_is_that_of_the_terminal() -> None:
    """Rich's own table is the oracle."""
    from rich._palettes import EIGHT_BIT_PALETTE

    assert [tuple(EIGHT_BIT_PALETTE[number]) for number in range(16, 256)] == list(TABLE)


def test_like_colours_are_pushed_apart() -> None:
    wanted = [(236, 234, 228), (236, 234, 229), (235, 234, 228)]
    found = told_apart(wanted, [TABLE[0]])
    apart = [np.linalg.norm(a - b) for i, a in enumerate(oklab(found)) for b in oklab(found)[:i]]
    assert min(apart) >= 0.06
    assert np.linalg.norm(oklab(found[:1]) - oklab(wanted[:1])) < 0.05, "the first is as wanted"
    assert len(set(told_apart([(0, 0, 0)] * 240))) == 240, "all there are"


def test_letters_can_be_read() -> None:
    for ground in TABLE:
        lightness = oklab([ground, ink_on(ground), faint_on(ground)])[:, 0]
        assert abs(lightness[0] - lightness[1]) > 0.35
        assert 0.05 < abs(lightness[0] - lightness[2]) < abs(lightness[0] - lightness[1])


def test_the_board_shows_agents_owners_amounts_and_beams(begin: Begin, orchard: ir.Game) -> None:
    looks, session = make_screen_looks(orchard), begin(agent=1)
    session.step(4)
    world = session.player.world
    world.cells["soil", "owner"][0] = 0
    world.cells["soil", "eaten"][1] = 7
    text = board_text(looks, snapshot_of(orchard, world, [0.0] * 2), own=1)
    lines = text.plain.splitlines()
    assert [len(line) for line in lines] == [16] * 4, "two letters a cell"
    assert lines[1][6:8] == "A0"
    assert lines[1][8:10] == "A7"
    for number, place in enumerate(world.position):
        assert place is not None
        assert lines[place.row][2 * place.col : 2 * place.col + 2] == f"{ARROWS[world.heading[number]]}{number}"
        style = style_at(text, place.row, place.col)
        assert (style.bgcolor == Color.parse(hexadecimal(OWN))) == (number == 1)
        assert style.dim == (number == 1), "who sang is held"
    mark, *_ = looks.marks.values()
    reached = {(row, col) for _, row, col in world.marks} - set(world.position)
    assert reached
    for row in range(4):
        for col in range(8):
            assert (style_at(text, row, col).bgcolor == Color.parse(hexadecimal(mark))) == ((row, col) in reached)


def style_at(text: Text, row: int, col: int) -> Style:
    """Returns the style of the first letter of a cell."""
    return text.get_style_at_offset(Console(), sum(len(line) + 1 for line in text.plain.splitlines()[:row]) + 2 * col)


def test_the_legend_names_what_is_on_the_map(orchard: ir.Game) -> None:
    said = legend(make_screen_looks(orchard), own=1).plain
    for line in (
        "A  soil, ripe",
        "n  soil, none",
        "#  wall",
        "cells that `sing` reaches",
        "▲1 the agent you steer",
        "soil (owner)",
        "soil (eaten)",
    ):
        assert line in said


def test_a_state_has_the_colour_of_its_picture(orchard: ir.Game) -> None:
    text = ORCHARD.read_text(encoding="utf-8").rstrip().removesuffix("}")
    looked = build(Source("orchard.sj", f'{text}  look soil where soil.fruit is ripe as blue gem\n  look floor as "#204060"\n}}\n')).game
    plain, drawn = make_screen_looks(orchard).tiles, make_screen_looks(looked).tiles
    ripe, floor = ("soil", ("ripe",)), ("floor", ())
    for state, colour in ((ripe, (0, 114, 178)), (floor, (32, 64, 96))):
        apart = np.linalg.norm(oklab([drawn[state][0]]) - oklab([colour]))
        assert apart < 0.1 < np.linalg.norm(oklab([plain[state][0]]) - oklab([colour]))
    assert drawn["wall", ()] == plain["wall", ()]


def test_agents_have_the_colours_of_their_pictures() -> None:
    """Those of their roles, of a `look`, or of their numbers."""
    text = ORCHARD.read_text(encoding="utf-8").rstrip().removesuffix("}")
    role = text.replace("timer tired", "timer tired  field role : { red, green } = green")
    looked = f"{text}  look agent where agent.tired > 0 as sky\n"
    for file, colours in (
        (text, (agent_colour(0), agent_colour(1))),
        (role, (read_colour("green"),) * 2),
        (looked, (agent_colour(0), read_colour("sky"))),
    ):
        game = build(Source("orchard.sj", file + "}\n")).game
        session = Session(Interpreted(game, default_params(game), 3), lambda *_: [3, 4], None, 12)
        session.step()
        looks, snapshot = make_screen_looks(game), session.moment.snapshot
        for row, col, colour in zip(snapshot.row.tolist(), snapshot.col.tolist(), colours, strict=True):
            shown = style_at(board_text(looks, snapshot), row, col).bgcolor
            assert shown == Color.parse(hexadecimal(looks.bodies["agent", colour]))
            assert np.linalg.norm(oklab([shown.triplet]) - oklab([colour])) < 0.1

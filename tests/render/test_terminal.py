"""Boards in letters: in a terminal of 256 colours everything that a game can show can be told apart."""

import numpy as np
import pytest
from rich.color import Color, ColorSystem

import sjdsl
from sjdsl.games_folder import bundled
from sjdsl.render.cells import board_cells, legend_cells, terminal_colour
from sjdsl.render.look import make_look
from sjdsl.render.snapshot import take_snapshot
from sjdsl.render.terminal import board_letters, board_text, legend_text
from sjdsl.runtime.env import Environment


@pytest.fixture(scope="module")
def env() -> Environment:
    return sjdsl.make("coins")


@pytest.mark.parametrize("name", bundled())
def test_whatever_a_game_shows_differs(name: str) -> None:
    look = make_look(sjdsl.make(name))
    cells = {text: cell for cell, text in legend_cells(look)}
    kinds_and_words = [cell for text, cell in cells.items() if text not in {label for label, _, _ in look.marks}]
    assert len(set(kinds_and_words)) == len(kinds_and_words), cells
    for cell in cells.values():
        assert len(cell.text) == 2
        assert {terminal_colour(cell.ink), terminal_colour(cell.ground)} == {cell.ink, cell.ground}


def test_its_colours_are_those_of_256_colours() -> None:
    for colour in [(3, 7, 11), (200, 90, 91), (128, 128, 128), (255, 255, 255), (86, 180, 233)]:
        shown = terminal_colour(colour)
        number = Color.from_rgb(*shown).downgrade(ColorSystem.EIGHT_BIT).get_truecolor()
        assert tuple(number) == shown, "a terminal shows it as it is"


def test_the_own_agent_stands_out(env: Environment) -> None:
    import jax

    _, state = env.reset(jax.random.key(0))
    snapshot, look = take_snapshot(env, state, np.zeros(2)), make_look(env)
    place = int(snapshot.row[1]), int(snapshot.col[1])
    plain, own = (board_cells(look, snapshot, number)[place[0]][place[1]] for number in (None, 1))
    assert plain.text == own.text
    assert own.ground != plain.ground
    assert own.ground not in {cell.ground for row in board_cells(look, snapshot) for cell in row}
    rows = board_text(look, snapshot, 1).plain.splitlines()
    assert {len(row) for row in rows} == {2 * look.width}
    assert "38;5;" in board_letters(look, snapshot)
    assert "38;2;" not in board_letters(look, snapshot)
    assert "coin" not in legend_text(look).plain and "green" in legend_text(look).plain

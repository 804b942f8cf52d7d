"""Another map for a game, by `--map` and by `map=`: the same checks, each mistake shown in the map file at its row and column."""

import shutil
from pathlib import Path

import pytest
from command_line import Sjdsl

import sjdsl as package
from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.library.games_folder import find_game

GOOD = "HFS..B\n.PPPP.\nPPP...\n"
# map of Clean Up, with what is wrong with it, where (line and column from 1, None: at the statement of the game), and in which words
WRONG = {
    "ragged": ("HFS..B\n.PPPP.\nPPP..\n", "SJ302", (3, 1), "row 2 has 5 characters, the others 6"),
    "unknown glyph": (
        "HFS..B\n.PP?P.\nPPPP..\n",
        "SJ301",
        (2, 4),
        "glyph `?` at row 1, column 3 is in no kind",
    ),
    "letter of the other case": ("HFS..b\n.PPPP.\nPPP...\n", "SJ301", (1, 6), "did you mean `B`?"),
    "after a byte order mark, with other line ends": (
        "\ufeffHFS..B\r\n.PP?P.\r\n",
        "SJ301",
        (2, 4),
        "row 1, column 3",
    ),
    "a game": (
        "sj 1\ngame x { }\n",
        "SJ309",
        None,
        "the map `other.txt` cannot be read: it is a game",
    ),
    "no cells": ("\n", "SJ307", (1, 1), "the map has no cells"),
    "too few starts": (
        "HFS..B\n.PPPP.\nP.P...\n",
        "SJ303",
        None,
        "`gate` has 6 cells for 7 agents",
    ),
}


@pytest.mark.parametrize(("text", "code", "place", "words"), WRONG.values(), ids=WRONG)
def test_a_mistake_in_a_map(
    sjdsl: Sjdsl, folder: Path, text: str, code: str, place: tuple[int, int] | None, words: str
) -> None:
    (folder / "other.txt").write_bytes(text.encode())
    shown = sjdsl("compile clean_up --map other.txt")
    assert shown.status == 1
    where = f"other.txt:{place[0]}:{place[1]}" if place else "clean_up.sj:"
    assert f"error[{code}] {where}" in shown.err or (
        place is None and f"error[{code}]" in shown.err and where in shown.err
    )
    assert words in shown.err
    assert not (folder / "generated").exists()
    with pytest.raises(CompileError) as error:
        package.make("clean_up", map="other.txt")
    found = next(d for d in error.value.diagnostics if d.code == code)
    assert words in f"{found.message} {found.hint}"
    if place:
        assert (found.span.file, found.span.line, found.span.column) == ("other.txt", *place)


def test_rows_that_are_given_have_a_place_too() -> None:
    with pytest.raises(CompileError) as error:
        package.make("clean_up", map=("HFS..B", ".PP?P.", "PPPP.."))
    (found,) = error.value.diagnostics
    assert (found.span.file, found.span.line, found.span.column) == ("map", 2, 4)


def test_a_map_that_is_not_there(sjdsl: Sjdsl, folder: Path) -> None:
    del folder
    shown = sjdsl("compile clean_up --map none.txt")
    assert (shown.status, shown.err.strip()) == (1, "error: there is no map file `none.txt`")
    with pytest.raises(FileNotFoundError, match=r"there is no map file `none\.txt`"):
        package.make("clean_up", map="none.txt")


def test_a_mistake_in_the_games_own_map_file(sjdsl: Sjdsl, folder: Path) -> None:
    """The place is one that can be opened from here."""
    (folder / "games/maps").mkdir(parents=True)
    (folder / "games/maps/pond.txt").write_text("HFS..B\n.PP?P.\n")
    bundled = find_game("clean_up")
    shutil.copytree(
        bundled.parent / "meltingpot/shared", folder / "games/meltingpot/shared"
    )  # what it extends
    (folder / "games/pond.sj").write_text(
        bundled.read_text().replace('"maps/clean_up.txt"', '"maps/pond.txt"', 1)
    )
    shown = sjdsl("compile games/pond.sj")
    assert "error[SJ301] games/maps/pond.txt:2:4" in shown.err
    assert "2 | .PP?P." in shown.err


def test_a_good_map_is_the_map(sjdsl: Sjdsl, folder: Path) -> None:
    (folder / "other.txt").write_text(GOOD)
    assert sjdsl("compile clean_up --map other.txt").status == 0
    assert "'.PPPP.'" in (folder / "generated/clean_up.py").read_text()
    rows = tuple(GOOD.split())
    assert (
        package.make("clean_up", map="other.txt").game.rows
        == rows
        == package.make("clean_up", map=rows).game.rows
    )

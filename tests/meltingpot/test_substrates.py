"""The table of substrates: which of Melting Pot's are there, that each builds without a warning, and the page made of it."""

from pathlib import Path

import pytest

from bench.game_pages import build_of, page_problems
from sjdsl.compiler.syntax.parse import parse
from sjdsl.compiler.syntax.read import read_source
from sjdsl.library.games_folder import bundled, find_game, main_games, melting_pot_games
from sjdsl.library.substrates import Substrate, substrates, written_substrates

PAGE = Path(__file__).parents[2] / "docs" / "meltingpot.md"


def test_every_substrate_is_written() -> None:
    assert [entry.name for entry in substrates().values() if not entry.game] == []


@pytest.mark.parametrize("entry", written_substrates(), ids=lambda entry: entry.name)
def test_a_substrate_builds_without_a_warning(entry: Substrate) -> None:
    made = build_of(entry)
    assert [str(warning) for warning in made.warnings] == []
    assert made.game.title
    assert not entry.roles or len(entry.roles) == made.game.agents.number


def test_every_file_is_a_substrate() -> None:
    """No game of the folder is left out of the table, and no two folders have a game of one name."""
    assert set(melting_pot_games()) <= {entry.game for entry in written_substrates()}
    assert len(set(bundled())) == len(main_games()) + len(melting_pot_games())
    for name in melting_pot_games():
        assert parse(read_source(find_game(name))).game.name.text == name


def test_families_are_found_by_name_and_meant_by_near_names() -> None:
    assert find_game("territory_open").parent.name == "meltingpot"
    assert find_game("territory").parent.name == "games"
    with pytest.raises(FileNotFoundError, match="did you mean `territory_open`"):
        find_game("teritory_open")
    with pytest.raises(FileNotFoundError, match="no bundled game `meltingpot/territory_open`"):
        find_game("meltingpot/territory_open")


def test_the_page_is_up_to_date() -> None:
    assert page_problems(PAGE) == [], "run `make docs`"

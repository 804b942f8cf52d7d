"""`sjdsl new --from GAME`: a copy of a game with its maps and bases, which plays as the game does and can be extended."""

from pathlib import Path

import pytest

from sjdsl.cli import run
from sjdsl.compiler import build, check
from sjdsl.compiler.ir.hash import game_hash
from sjdsl.compiler.syntax.read import read_source
from sjdsl.library.games_folder import find_game


def new(folder: Path, *arguments: str) -> int:
    return run(["new", *arguments, "-o", str(folder)])


@pytest.mark.parametrize("game", ["clean_up", "harvest_closed", "chicken_in_the_matrix"])
def test_a_copy_is_the_game(game: str, tmp_path: Path) -> None:
    assert new(tmp_path, "--from", game) == 0
    original, copy = (
        build(read_source(path)).game for path in (find_game(game), tmp_path / f"{game}.sj")
    )
    assert game_hash(copy) == game_hash(original)
    for variant in original.variants:
        assert [
            d
            for d in check(read_source(tmp_path / f"{game}.sj"), (variant,))
            if d.severity == "error"
        ] == []


def test_a_copy_has_the_name_that_was_asked_for(tmp_path: Path) -> None:
    assert new(tmp_path, "mine", "--from", "coins") == 0
    assert build(read_source(tmp_path / "mine.sj")).game.name == "mine"
    assert new(tmp_path, "mine", "--from", "coins") == 1, "nothing is overwritten"


def test_a_bundled_game_is_extended_by_way_of_a_copy(tmp_path: Path) -> None:
    path = tmp_path / "mine.sj"
    path.write_text('sj 1\ngame mine extends "clean_up" { set respawn_delay = 2 }\n')
    (problem,) = check(read_source(path))
    assert problem.code == "SJ111"
    assert "sjdsl new --from clean_up" in problem.hint
    assert 'extends "clean_up.sj"' in problem.hint
    new(tmp_path, "--from", "clean_up")
    path.write_text('sj 1\ngame mine extends "clean_up.sj" { set respawn_delay = 2 }\n')
    assert check(read_source(path)) == ()


def test_a_map_outside_the_folder_is_not_copied(tmp_path: Path) -> None:
    (tmp_path / "secret.txt").write_text("..")
    (tmp_path / "game").mkdir()
    (tmp_path / "game" / "odd.sj").write_text('sj 1\ngame odd { map "../secret.txt" }\n')
    (tmp_path / "copy").mkdir()
    code = new(tmp_path / "copy", "--from", str(tmp_path / "game" / "odd.sj"))
    assert code != 0
    assert list((tmp_path / "copy").iterdir()) == []

"""Files that a game names: through links, in circles, and those that are no files at all."""

import os
import shutil
from pathlib import Path

import pytest
from test_generated_text import written

from sjdsl.cli import run
from sjdsl.compiler import check
from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.compiler.syntax.read import read_source
from sjdsl.editor.session import Session
from sjdsl.library.checked_game import map_rows

SECRET = "the password is a word\n"


@pytest.fixture
def games(tmp_path: Path) -> Path:
    """A folder with a game whose map is a file in `maps/`, and beside the folder a secret."""
    (tmp_path / "secret.txt").write_text(SECRET)
    folder = tmp_path / "games"
    (folder / "maps").mkdir(parents=True)
    game = written("tiny.sj", folder)
    text = game.read_text()
    start = text.index("map {")
    rows = text[start : text.index("}", start) + 1]
    game.write_text(text.replace(rows, 'map "maps/tiny.txt"'))
    (folder / "maps" / "tiny.txt").write_text("".join(f"{row}\n" for row in rows.split('"')[1::2]))
    assert errors(game) == []
    return folder


def errors(game: Path) -> list[tuple[str, str]]:
    return [(d.code, d.message) for d in check(read_source(game)) if d.severity == "error"]


def shown(game: Path) -> list[str]:
    """Returns the errors that an editor shows."""
    session = Session()
    session.open(game.as_uri(), game.read_text())
    return [str(d.code) for d in session.diagnostics(game.as_uri()) if d.severity == 1]


def test_a_link_to_a_folder_of_games(games: Path, tmp_path: Path) -> None:
    (tmp_path / "linked").symlink_to(games)
    assert errors(tmp_path / "linked" / "tiny.sj") == []
    assert shown(tmp_path / "linked" / "tiny.sj") == []


def test_a_link_inside_the_folder(games: Path) -> None:
    (games / "maps").rename(games / "drawn")
    (games / "maps").symlink_to("drawn")
    assert errors(games / "tiny.sj") == []


@pytest.mark.parametrize("layout", ["each file", "the folder of maps"])
def test_links_to_another_package(layout: str, games: Path, tmp_path: Path) -> None:
    """Package managers put links to the game and to its maps into one folder."""
    farm = tmp_path / "farm"
    farm.mkdir()
    (farm / "tiny.sj").symlink_to(games / "tiny.sj")
    if layout == "each file":
        (farm / "maps").mkdir()
        (farm / "maps" / "tiny.txt").symlink_to(games / "maps" / "tiny.txt")
    else:
        (farm / "maps").symlink_to(games / "maps")
    assert errors(farm / "tiny.sj") == []
    assert shown(farm / "tiny.sj") == []


def test_links_to_a_store_of_contents(games: Path, tmp_path: Path) -> None:
    """Hubs keep each file under a digest; names are links."""
    store, snapshot = tmp_path / "store", tmp_path / "snapshot"
    store.mkdir()
    (snapshot / "maps").mkdir(parents=True)
    for number, name in enumerate(("tiny.sj", "maps/tiny.txt")):
        (games / name).rename(store / str(number))
        (snapshot / name).symlink_to(store / str(number))
    child = snapshot / "child.sj"
    (store / "2").write_text('sj 1\ngame child extends "tiny.sj" { }\n')
    child.symlink_to(store / "2")
    assert errors(snapshot / "tiny.sj") == []
    assert errors(child) == []
    assert shown(child) == []


@pytest.mark.parametrize("link", ["maps/tiny.txt", "maps"])
def test_a_link_out_of_the_folder_is_refused(link: str, games: Path, tmp_path: Path) -> None:
    outside = tmp_path / "outside"
    outside.mkdir()
    (outside / "tiny.txt").write_text(SECRET)
    linked = games / link
    if linked.is_dir():
        shutil.rmtree(linked)
    else:
        linked.unlink()
    target = outside / Path(link).name if "/" in link else outside
    linked.symlink_to(target)
    wrong = f"`maps/tiny.txt` leaves the folder of the game: `{link}` is a link to `{target}`"
    assert errors(games / "tiny.sj") == [("SJ112", wrong)]
    assert shown(games / "tiny.sj") == ["SJ112"]


def test_a_link_to_nothing(games: Path) -> None:
    (games / "maps" / "tiny.txt").unlink()
    (games / "maps" / "tiny.txt").symlink_to("gone.txt")
    assert errors(games / "tiny.sj") == [
        ("SJ008", "`maps/tiny.txt` cannot be read: it is a link to a file that is not there")
    ]


@pytest.mark.parametrize(
    "name", ["a.sj", "sub/../a.sj", "here/a.sj", "other.sj", "./sub/back/a.sj", "hard.sj"]
)
def test_a_circle_by_any_path(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    game = tmp_path / "a.sj"
    game.write_text(f'sj 1\ngame a extends "{name}" {{ }}\n')
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "back").symlink_to("..")
    (tmp_path / "here").symlink_to(".")
    (tmp_path / "other.sj").symlink_to("a.sj")
    os.link(game, tmp_path / "hard.sj")
    assert [code for code, _ in errors(game)] == ["SJ110"]
    assert shown(game) == ["SJ110"]
    assert run(["check", str(game)]) == 1
    assert run(["new", "b", "--from", str(game)]) == 1
    assert "comes back to" in capsys.readouterr().err


def test_a_circle_of_texts_that_are_not_saved(tmp_path: Path) -> None:
    session = Session()
    for name, base in (("a", "b"), ("b", "sub/../a")):
        session.open(
            (tmp_path / f"{name}.sj").as_uri(), f'sj 1\ngame {name} extends "{base}.sj" {{ }}\n'
        )
    (tmp_path / "sub").mkdir()
    assert [d.code for d in session.diagnostics((tmp_path / "a.sj").as_uri())] == ["SJ110"]


def test_a_long_chain_is_no_circle(games: Path) -> None:
    for number in range(300):
        base = f"g{number - 1}.sj" if number else "tiny.sj"
        (games / f"g{number}.sj").write_text(f'sj 1\ngame g{number} extends "{base}" {{ }}\n')
    assert errors(games / "g299.sj") == []


@pytest.mark.parametrize("kind", ["pipe", "device", "folder"])
def test_what_is_no_file_is_not_waited_for(
    kind: str, games: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def place(path: Path) -> Path:
        if kind == "pipe":
            os.mkfifo(path)
        elif kind == "device":
            path.symlink_to("/dev/zero")
        else:
            path.mkdir()
        return path

    game = place(games / "odd.sj")
    for command in ("check", "fmt", "doc", "dump"):
        after = ["--after", "ast"] if command == "dump" else []
        assert run([command, str(game), *after]) == 1, command
    assert run(["new", "b", "--from", str(game)]) == 1
    assert "Traceback" not in capsys.readouterr().err

    (games / "maps" / "tiny.txt").unlink()
    place(games / "maps" / "tiny.txt")
    assert [code for code, _ in errors(games / "tiny.sj")] == [
        "SJ112" if kind == "device" else "SJ309"
    ]
    with pytest.raises(CompileError, match="cannot be read"):
        map_rows(games / "maps" / "tiny.txt", read_source(games / "tiny.sj"))

    (games / "child.sj").write_text('sj 1\ngame child extends "odd.sj" { }\n')
    assert [code for code, _ in errors(games / "child.sj")] == [
        "SJ112" if kind == "device" else "SJ008"
    ]

"""`sjdsl new --package`: a package whose game is found where it is installed (its own tests: `tests/packaging/test_new_package.py`)."""

import tomllib
from pathlib import Path

import pytest
from command_line import Sjdsl
from installed_packages import register

from sjdsl.library.games_folder import find_game
from sjdsl.version import HOMEPAGE

FILES = {
    "pyproject.toml",
    "README.md",
    ".gitignore",
    ".github/workflows/tests.yml",
    "src/river_games/__init__.py",
    "src/river_games/river.sj",
    "src/river_games/river.txt",
    "tests/test_river.py",
}


def test_a_package_is_written(sjdsl: Sjdsl, folder: Path) -> None:
    made = sjdsl("new", "--package", "river_games")
    assert made.status == 0
    home = folder / "river_games"
    assert {path.relative_to(home).as_posix() for path in home.rglob("*") if path.is_file()} == FILES
    project = tomllib.loads((home / "pyproject.toml").read_text())
    assert project["project"]["name"] == "river-games"
    assert project["project"]["entry-points"] == {"sjdsl.games": {"river_games": "river_games"}}
    assert project["project"]["dependencies"] == ["sjdsl>=0.1"]
    assert HOMEPAGE in (home / "README.md").read_text()
    assert sjdsl("check", "--strict", "river_games/src/river_games/river.sj").status == 0
    assert sjdsl("fmt", "--check", "river_games").status == 0
    left = [path for path in home.rglob("*") if path.is_file() and any(word in path.read_text() for word in ("NAME", "PACKAGE", "TITLE"))]
    assert left == [], "every word of the templates was replaced"


def test_its_game_is_found_where_it_is_installed(sjdsl: Sjdsl, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    sjdsl("new", "--package", "river_games")
    source = folder / "river_games/src"
    entries = tomllib.loads((folder / "river_games/pyproject.toml").read_text())["project"]["entry-points"]["sjdsl.games"]
    ((name, value),) = entries.items()
    register(source, "river-games", name, value, "0.1.0")
    monkeypatch.syspath_prepend(source)
    assert find_game("river") == source / "river_games/river.sj"
    assert "of river-games 0.1.0\n" in sjdsl("list").out

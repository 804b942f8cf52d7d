"""The package that `sjdsl new --package` makes: built, installed beside the wheel, found by name, and its own tests pass."""

from pathlib import Path
from zipfile import ZipFile

import pytest

from tests.packaging.installed import run_in


@pytest.mark.thorough
def test_the_package_is_built_installed_and_tested(installed: Path, tmp_path: Path) -> None:
    sjdsl, python = installed / "empty/bin/sjdsl", installed / "empty/bin/python"
    run_in(sjdsl, "new", "--package", "river_games", cwd=tmp_path)
    home, site = tmp_path / "river_games", tmp_path / "site"
    build = ("-m", "pip", "wheel", "-q", "--no-deps", "--no-build-isolation", "-w", "../dist", ".")
    run_in(python, *build, cwd=home)
    (built,) = (tmp_path / "dist").glob("*.whl")
    names = set(ZipFile(built).namelist())
    assert {"river_games/river.sj", "river_games/river.txt"} <= names
    run_in(python, "-m", "pip", "install", "-q", "--no-deps", "--target", site, built, cwd=tmp_path)
    there = ("env", f"PYTHONPATH={site}")
    listed = run_in(*there, sjdsl, "list", cwd=tmp_path)
    assert "\nof river-games 0.1.0\nriver " in listed
    use = "import sys, sjdsl; assert sjdsl.make('river').num_agents == 3; assert 'river_games' not in sys.modules"
    run_in(*there, python, "-c", use, cwd=tmp_path)
    assert "6 passed" in run_in(*there, python, "-m", "pytest", "-p", "no:cacheprovider", cwd=home)

"""The wheel alone: installed where nothing of this tree can be seen, it compiles, lists, makes and trains."""

from pathlib import Path

import pytest

from tests.packaging.installed import GAME, run_in, site_packages
from tests.packaging.newcomer import differs, walk

USE = """
import pathlib, sjdsl, sjdsl.trainers, sjdsl.bench, sjdsl.render
from sjdsl.compiler.diagnostics.explanations import explain
assert "site-packages" in sjdsl.__file__, sjdsl.__file__
assert sjdsl.make("coins").num_agents == 2
assert sjdsl.make("my_game.sj").num_agents == 1
assert sjdsl.make("territory_open", variant="rooms").num_agents == 9
assert sjdsl.trainers.load_preset("two_cores").config.num_steps == 1000
assert explain("SJ101")
from sjdsl.studio.tour import games, tour_folder
assert len(games()) == 6 and all((tour_folder() / name.removeprefix("tour:")).is_file() for name in games())
"""


@pytest.mark.thorough
def test_only_sjdsl_is_installed(installed: Path) -> None:
    names = {path.name for path in site_packages(installed).iterdir() if path.name != "__pycache__"}
    assert {name for name in names if not name.endswith((".dist-info", ".pth"))} == {"sjdsl"}


@pytest.mark.thorough
def test_it_works_in_an_empty_folder(installed: Path, tmp_path: Path) -> None:
    (tmp_path / "my_game.sj").write_text(GAME)
    shell = installed / "empty/bin"
    assert "generated/my_game.py" in run_in(shell / "sjdsl", "compile", "my_game.sj", cwd=tmp_path)
    listed = run_in(shell / "sjdsl", "list", cwd=tmp_path)
    assert "clean_up" in listed and "territory_open" in listed
    assert "no problems" in run_in(shell / "sjdsl", "check", "my_game.sj", "coins", cwd=tmp_path)
    run_in(shell / "python", "-c", USE, cwd=tmp_path)


@pytest.mark.slow
def test_it_trains_in_an_empty_folder(installed: Path, tmp_path: Path) -> None:
    (tmp_path / "my_game.sj").write_text(GAME)
    small = [
        part
        for value in ("total_timesteps=96", "num_envs=4", "num_steps=12", "num_minibatches=1")
        for part in ("--set", value)
    ]
    shown = run_in(
        installed / "empty/bin/sjdsl",
        "train",
        "my_game.sj",
        *small,
        "--run",
        "run",
        "--episodes",
        "2",
        cwd=tmp_path,
    )
    assert "run/" in shown
    assert (tmp_path / "run/policies/last.safetensors").exists()


@pytest.mark.thorough
def test_a_new_game_begins_in_an_empty_folder(installed: Path, tmp_path: Path) -> None:
    shell = installed / "empty/bin"
    run_in(shell / "sjdsl", "new", "pond", cwd=tmp_path)
    run_in(shell / "sjdsl", "compile", "--standalone", "pond.sj", cwd=tmp_path)
    run_in(
        shell / "python",
        "-c",
        "from pond_standalone import Environment; assert Environment().num_agents == 3",
        cwd=tmp_path,
    )


@pytest.mark.thorough
def test_a_newcomer_sees_a_changed_rule(installed: Path, tmp_path: Path) -> None:
    """What `make newcomer` times: a new game, its page, a changed rule, and the page of that."""
    assert differs(
        *walk(
            lambda *command: run_in(*command, cwd=tmp_path), installed / "empty/bin/sjdsl", tmp_path
        )
    )

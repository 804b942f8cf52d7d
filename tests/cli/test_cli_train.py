"""`sjdsl train` and `evaluate` on a small game: the files of a run, and a run found again."""

import json
from pathlib import Path

import pytest
from command_line import Sjdsl

SMALL = ("total_timesteps=96", "num_envs=4", "num_steps=12", "num_minibatches=1", "num_epochs=1", "network=mlp")
QUICK = [part for value in SMALL for part in ("--set", value)]


def test_a_run_can_be_evaluated_and_drawn(sjdsl: Sjdsl, folder: Path) -> None:
    trained = sjdsl("train", "orchard.sj", *QUICK, "--reward", "common", "--param", "apple=2", "--episodes", "0")
    assert trained.status == 0, trained.text
    run_dir = Path("runs/orchard_ippo_common_seed0")
    assert f"{run_dir}/" in trained.out
    assert "metrics.csv" in trained.out
    manifest = json.loads((run_dir / "manifest.json").read_text())
    assert manifest["provenance"]["params"] == {"apple": 2}
    assert manifest["provenance"]["game"] == str(folder / "orchard.sj")

    evaluated = sjdsl("evaluate", run_dir, "--episodes", "3")
    assert evaluated.status == 0, evaluated.text
    assert "means of 3 episodes" in evaluated.out
    assert "trained return" in evaluated.out
    assert json.loads((run_dir / "evaluation.json").read_text())["episodes"] == 3

    drawn = sjdsl("render", "orchard.sj", "--policy", run_dir, "--steps", "2", "-o", "film.gif")
    assert drawn.status == 0, drawn.text
    assert (folder / "film.gif").stat().st_size > 0


def test_a_folder_in_use_is_not_written_to(sjdsl: Sjdsl, folder: Path) -> None:
    (folder / "kept").mkdir()
    (folder / "kept/notes.txt").write_text("mine")
    shown = sjdsl("train", "orchard.sj", *QUICK, "--run", "kept")
    assert shown.status == 1
    assert "not empty" in shown.err


def test_a_preset_names_the_game(sjdsl: Sjdsl, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from sjdsl.cli import train as module

    seen = {}
    monkeypatch.setattr(module, "make_environment", lambda described: seen.update(described) or _stop())
    (folder / "p.toml").write_text('game = "coins"\n[environment]\nparams = { length = 20 }\n[config]\nseed = 3\n')
    sjdsl("train", "--preset", "p.toml", "--param", "spawn=0.1")
    assert seen["game"] == "coins"
    assert seen["params"] == {"length": 20, "spawn": 0.1}
    sjdsl("train", "orchard.sj", "--preset", "p.toml")
    assert seen["params"] == {}, "another game does not take the preset's environment"


def _stop() -> None:
    import click

    raise click.ClickException("far enough")

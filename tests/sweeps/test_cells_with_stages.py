"""Sweeps of a preset with stages."""

import csv
import json
from pathlib import Path

import pytest

from sjdsl.experiments.refusals import ExperimentError
from sjdsl.sweeps import SweepSpec, sweep, work
from sjdsl.sweeps.axes import read_axis
from sjdsl.sweeps.cells import Cell
from sjdsl.sweeps.folder import steps_of
from tests.sweeps.described import GAME, TINY, plan

PRESET = """
[[stages]]
environment = { map = "small.txt", num_agents = 3, params = { apple = 2 } }
config = { reward = "common", total_timesteps = 8192 }
[[stages]]
config.total_timesteps = 16384
"""


def test_a_cell_has_the_stages_of_its_preset(tmp_path: Path) -> None:
    (tmp_path / "p.toml").write_text(PRESET)
    cell, _ = plan("gamma=0.5,0.9", preset=str(tmp_path / "p.toml"))
    (first,) = cell.earlier
    assert first.provenance == {
        "game": "coins",
        "variant": None,
        "map": "small.txt",
        "num_agents": 3,
        "params": {"apple": 2},
    }
    assert cell.provenance == {
        "game": "coins",
        "variant": None,
        "map": None,
        "num_agents": None,
        "params": {},
    }
    assert [(stage.config["reward"], stage.config["gamma"]) for stage in cell.stages] == [
        ("common", 0.5),
        ("individual", 0.5),
    ]
    assert steps_of(cell) == 8192 + 16384
    assert Cell.read(cell.name, json.loads(json.dumps(cell.described()))) == cell
    (common,) = plan(
        "common_reward=mean", preset=str(tmp_path / "p.toml")
    )  # which only the first stage reads
    assert common.earlier[0].config["common_reward"] == "mean"


@pytest.mark.parametrize(
    ("axis", "changes", "name"),
    [
        ("reward=common,individual", {}, "reward"),
        ("param.apple=1", {}, "param.apple"),
        ("gamma=0.9", {"num_agents": 2}, "num_agents"),
        ("gamma=0.9", {"map": "other.txt"}, "map"),
        ("gamma=0.9", {"params": {"apple": 3}}, "param.apple"),
    ],
)
def test_what_stages_set_is_no_axis(
    tmp_path: Path, axis: str, changes: dict[str, object], name: str
) -> None:
    (tmp_path / "p.toml").write_text(PRESET)
    with pytest.raises(
        ExperimentError, match=rf"p\.toml: stages set `{name}` themselves: change it there"
    ):
        plan(axis, preset=str(tmp_path / "p.toml"), **changes)


def test_stages_of_a_run_that_has_hardly_begun_are_cleared(tmp_path: Path) -> None:
    (tmp_path / "stages/1").mkdir(parents=True)
    (tmp_path / "stages/1/manifest.json").touch()
    (tmp_path / ".lock").touch()
    work._remove_unstarted(tmp_path)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.thorough
def test_a_sweep_of_runs_in_stages(tmp_path: Path) -> None:
    preset = tmp_path / "p.toml"
    preset.write_text(
        "[[stages]]\nconfig = { total_timesteps = 32, reward = 'common' }\n[[stages]]\nconfig.total_timesteps = 16\n"
    )
    settings = {name: value for name, value in TINY.items() if name != "total_timesteps"}
    spec = SweepSpec([GAME], [read_axis("gamma=0.5")], settings, str(preset), episodes=2)
    outcome = sweep(spec, tmp_path / "sweep")
    assert outcome.failed == {}
    (name,) = outcome.done
    rows = list(csv.DictReader((tmp_path / "sweep/results.csv").read_text().splitlines()))
    assert [(row["seed"], row["reward"], row["env_steps"]) for row in rows] == [
        (seed, "individual from stages", "48") for seed in "01"
    ]
    assert (tmp_path / "sweep/cells" / name / "stages/1/seed_1/policies/last.safetensors").is_file()
    assert sweep(spec, tmp_path / "sweep").done == (name,)

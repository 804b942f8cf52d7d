"""Engines of sweeps: Ray on this machine, and submitit's local executor in place of Slurm, come to the results of one process."""

import json
import os
import signal
import time
from pathlib import Path
from typing import Any

import pytest

from sjdsl.experiments.refusals import ExperimentError
from sjdsl.sweeps.axes import Axis
from sjdsl.sweeps.engines import Crew
from sjdsl.sweeps.plan import Asked
from sjdsl.sweeps.running import sweep

GAME = str(Path(__file__).parents[1] / "experiments" / "games" / "matrix_game.sj")
TINY: dict[str, Any] = {"network": "mlp", "network_width": 4, "num_envs": 4, "num_steps": 4, "num_minibatches": 1, "num_epochs": 1}
TINY |= {"total_timesteps": 16 * 4, "checkpoint_updates": 1, "seeds": 1}


def asked(**settings: Any) -> Asked:
    return Asked([GAME], [Axis("reward", ("individual", "common"))], settings={**TINY, **settings}, episodes=2)


def results(folder: Path) -> bytes:
    return (folder / "results.csv").read_bytes()


@pytest.fixture(scope="module")
def alone(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("alone") / "sweep"
    sweep(asked(), folder)
    return folder


@pytest.fixture(autouse=True)
def on_the_cpu(monkeypatch: pytest.MonkeyPatch) -> None:
    """Other processes compute where this one does."""
    monkeypatch.setenv("JAX_PLATFORMS", "cpu")


def check_same(folder: Path, alone: Path, outcome: Any) -> None:
    assert len(outcome.done) == 2
    assert results(folder) == results(alone)


def test_spawned_processes(alone: Path, tmp_path: Path) -> None:
    check_same(tmp_path / "sweep", alone, sweep(asked(), tmp_path / "sweep", crew=Crew(workers=2)))


def test_ray(alone: Path, tmp_path: Path) -> None:
    pytest.importorskip("ray")
    check_same(tmp_path / "sweep", alone, sweep(asked(), tmp_path / "sweep", crew=Crew("ray", workers=2)))


def test_submitit(alone: Path, tmp_path: Path) -> None:
    pytest.importorskip("submitit")
    said: list[str] = []
    crew = Crew("slurm", options={"cluster": "local", "timeout_min": 10}, tell=said.append)
    check_same(tmp_path / "sweep", alone, sweep(asked(), tmp_path / "sweep", crew=crew))
    assert said[0].startswith("2 jobs are queued; their output is in ")


def test_a_job_that_is_told_to_stop_saves_and_is_queued_again(tmp_path: Path) -> None:
    """The signal comes while it trains: what was done is kept, and the job that takes its place goes on with it."""
    submitit = pytest.importorskip("submitit")
    long = asked(total_timesteps=16 * 3000, checkpoint_updates=0, policy_every=1000)
    long = Asked(long.games, [Axis("reward", ("individual",))], settings=long.settings, episodes=2)
    folder = tmp_path / "sweep"
    submit = submitit.AutoExecutor.map_array

    def interrupted(self: Any, *given: Any) -> Any:
        jobs = submit(self, *given)
        interrupt(folder)
        return jobs

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(submitit.AutoExecutor, "map_array", interrupted)
        outcome = sweep(long, folder, crew=Crew("slurm", options={"cluster": "local", "timeout_min": 60}))
    assert len(outcome.done) == 1
    rows = (folder / "cells" / outcome.done[0] / "metrics.jsonl").read_text().splitlines()
    assert len(rows) == 3000
    manifest = (folder / "cells" / outcome.done[0] / "manifest.json").read_text()
    assert '"resumed"' in manifest


def interrupt(folder: Path) -> None:
    """Sends the job that runs the cell the signal of submitit when it has trained a little."""
    until = time.monotonic() + 300
    lines = folder / "cells" / "matrix_game_reward-individual" / "metrics.jsonl"
    while not (lines.exists() and lines.read_bytes().count(b"\n") >= 100):
        assert time.monotonic() < until
        time.sleep(0.01)
    (claim,) = (folder / "claims").glob("*@0.json")
    os.kill(json.loads(claim.read_text())["pid"], signal.SIGUSR2)


def test_no_slurm_here(tmp_path: Path) -> None:
    pytest.importorskip("submitit")
    with pytest.raises(ExperimentError, match="the engine slurm: "):
        sweep(asked(), tmp_path / "sweep", crew=Crew("slurm"))

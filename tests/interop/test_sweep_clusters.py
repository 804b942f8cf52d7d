"""Sweeps on clusters, as the examples run them: Ray on this machine, and submitit's local executor in place of Slurm."""

import os
import signal
import time
from pathlib import Path
from typing import Any

import psutil
import pytest

from sjdsl.sweeps import Axis, SweepSpec, sweep

GAME = str(Path(__file__).parents[1] / "experiments" / "games" / "matrix_game.sj")
TINY: dict[str, Any] = {
    "network": "mlp",
    "network_width": 4,
    "num_envs": 4,
    "num_steps": 4,
    "num_minibatches": 1,
    "num_epochs": 1,
}
TINY |= {"total_timesteps": 16 * 4, "checkpoint_updates": 1, "seeds": 1}


def asked(*rewards: str, **settings: Any) -> SweepSpec:
    return SweepSpec(
        [GAME],
        [Axis("reward", rewards or ("individual", "common"))],
        settings={**TINY, **settings},
        episodes=2,
    )


def results(folder: Path) -> bytes:
    return (folder / "results.csv").read_bytes()


@pytest.fixture(scope="module")
def alone(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("alone") / "sweep"
    sweep(asked(), folder)
    return folder


@pytest.fixture(autouse=True)
def on_the_cpu(monkeypatch: pytest.MonkeyPatch) -> None:
    """Other processes compute where this one does, and find the examples."""
    monkeypatch.setenv("JAX_PLATFORMS", "cpu")
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parents[2]))


def test_spawned_processes(alone: Path, tmp_path: Path) -> None:
    assert len(sweep(asked(), tmp_path / "sweep", workers=2).done) == 2
    assert results(tmp_path / "sweep") == results(alone)


def test_ray(alone: Path, tmp_path: Path) -> None:
    pytest.importorskip("ray")
    from examples.sweep_ray import main

    assert main(str(tmp_path / "sweep"), asked()) == ["done", "done"]
    assert results(tmp_path / "sweep") == results(alone)


def test_submitit(alone: Path, tmp_path: Path) -> None:
    pytest.importorskip("submitit")
    from examples.sweep_slurm import main

    assert main(str(tmp_path / "sweep"), asked(), cluster="local") == ["done", "done"]
    assert results(tmp_path / "sweep") == results(alone)


def test_a_job_that_is_pre_empted_goes_on_from_its_last_checkpoint(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    submitit = pytest.importorskip("submitit")
    from examples.sweep_slurm import main

    folder, submit = tmp_path / "sweep", submitit.AutoExecutor.map_array

    def interrupted(self: Any, *given: Any) -> Any:
        jobs = submit(self, *given)
        interrupt(folder)
        return jobs

    monkeypatch.setattr(submitit.AutoExecutor, "map_array", interrupted)
    long = asked("individual", total_timesteps=16 * 3000, checkpoint_updates=50, policy_every=1000)
    assert main(str(folder), long, cluster="local") == ["done"]
    run = folder / "cells" / "matrix_game_reward-individual"
    assert len((run / "metrics.jsonl").read_text().splitlines()) == 3000
    assert '"resumed"' in (run / "manifest.json").read_text()


def interrupt(folder: Path) -> None:
    """Sends the job that runs the cell the signal of submitit when it has trained a little."""
    until = time.monotonic() + 300
    lines = folder / "cells" / "matrix_game_reward-individual" / "metrics.jsonl"
    while not (lines.exists() and lines.read_bytes().count(b"\n") >= 100):
        assert time.monotonic() < until
        time.sleep(0.01)
    lock = str(folder / "locks" / "matrix_game_reward-individual.lock")
    ours = psutil.Process().children(recursive=True)
    (job,) = [process for process in ours if lock in {file.path for file in process.open_files()}]
    os.kill(job.pid, signal.SIGUSR2)

"""GPUs of a machine and how the processes of a sweep share them, with a listing in place of GPUs."""

import subprocess
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import jax
import pytest

from sjdsl.experiments.refusals import ExperimentError
from sjdsl.sweeps import gpus as module
from sjdsl.sweeps import running
from sjdsl.sweeps.axes import Axis
from sjdsl.sweeps.cells import SweepSpec
from sjdsl.sweeps.gpus import describe_shares, gpus_for_workers, usable_gpus, variables_of_workers
from sjdsl.sweeps.running import sweep
from sjdsl.sweeps.work import Watch
from tests.sweeps.described import GAME, TINY

VISIBLE, RESERVING = "CUDA_VISIBLE_DEVICES", "XLA_PYTHON_CLIENT_PREALLOCATE"


@pytest.fixture(autouse=True)
def driver(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "driver").touch()
    monkeypatch.setattr(module, "DEVICES", (tmp_path / "driver",))
    for name in module.MEMORY:
        monkeypatch.delenv(name, raising=False)


def answer(monkeypatch: pytest.MonkeyPatch, status: int, out: str, error: str = "") -> None:
    """Has the process that counts GPUs give an answer."""
    monkeypatch.setattr(
        subprocess, "run", lambda *_, **__: subprocess.CompletedProcess([], status, out, error)
    )


@pytest.mark.parametrize(
    ("count", "visible", "names"),
    [
        (3, None, ["0", "1", "2"]),
        (0, None, []),
        (2, "4,7", ["4", "7"]),
        (2, "GPU-8a, GPU-1c", ["GPU-8a", "GPU-1c"]),
        (1, "3,-1,2", ["3"]),  # CUDA ends the list at what it doesn't know
        (0, "", []),
        (1, "MIG-1,MIG-2", ["MIG-1", "MIG-2"]),
    ],
)
def test_gpus_are_those_that_jax_uses_and_the_user_has_listed(
    monkeypatch: pytest.MonkeyPatch, count: int, visible: str | None, names: list[str]
) -> None:
    monkeypatch.delenv(VISIBLE, raising=False)
    if visible is not None:
        monkeypatch.setenv(VISIBLE, visible)
    answer(monkeypatch, 0, f"a note\n{count}\n")
    assert usable_gpus() == names


def test_without_a_driver_nothing_is_started(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "DEVICES", ("/no/such/driver",))
    monkeypatch.setattr(subprocess, "run", None)
    assert usable_gpus() == []


def test_a_single_process_keeps_all_gpus(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(subprocess, "run", None)
    assert gpus_for_workers(1) == []


def test_a_jax_that_does_not_start_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    answer(monkeypatch, 1, "", "Traceback\nRuntimeError: no backend `cuda`\n")
    with pytest.raises(
        ExperimentError,
        match=r"JAX doesn't start, so its GPUs can't be counted: RuntimeError: no backend `cuda`$",
    ):
        usable_gpus()


@pytest.mark.thorough
@pytest.mark.skipif(jax.default_backend() != "cpu", reason="there are GPUs")
def test_a_driver_without_a_gpu_for_jax() -> None:
    assert usable_gpus() == []


@pytest.mark.parametrize(
    ("gpus", "workers", "seen", "words"),
    [
        (["0", "1"], 2, ["0", "1"], "2 processes have a GPU each"),
        (["4", "5", "6"], 2, ["4", "5"], "2 processes have a GPU each; 1 more is not used"),
        (["0", "1"], 5, ["0", "1", "0", "1", "0"], "5 processes share 2 GPUs"),
        (["7"], 2, ["7", "7"], "2 processes share 1 GPU"),
    ],
)
def test_each_worker_sees_one_gpu(
    monkeypatch: pytest.MonkeyPatch, gpus: list[str], workers: int, seen: list[str], words: str
) -> None:
    variables = variables_of_workers(gpus, workers)
    assert [own[VISIBLE] for own in variables] == seen
    assert all(
        own.get(RESERVING) == ("false" if workers > len(gpus) else None) for own in variables
    )
    assert describe_shares(gpus, workers) == words
    monkeypatch.setenv("XLA_CLIENT_MEM_FRACTION", ".3")
    assert variables_of_workers(gpus, workers) == [{VISIBLE: gpu} for gpu in seen], (
        "the user has shared the memory out"
    )


def test_without_gpus_workers_keep_their_environment() -> None:
    assert variables_of_workers([], 2) == [{}, {}]


@pytest.mark.parametrize("ratios", [(0.25, 0.75), (0.25,)])
def test_cells_run_in_processes_with_a_gpu_each(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, ratios: tuple[float, ...]
) -> None:
    """Even a single one: this process has left the GPUs alone."""
    started: list[Any] = []

    def run(folders: Sequence[Path], workers: int, gpus: Sequence[str]) -> bool:
        started.append((len(folders), workers, gpus))
        return False

    monkeypatch.setattr(module, "usable_gpus", lambda: ["2", "3", "5"])
    monkeypatch.setattr(running, "run_in_processes", run)
    told: list[str] = []
    spec = SweepSpec(
        [GAME], [Axis("exchange_ratio", ratios)], settings={**TINY, "reward": "exchange"}
    )
    assert len(
        sweep(spec, tmp_path / "swept", workers=2, watch=Watch(tell=told.append)).stopped
    ) == len(ratios)
    assert started == [(len(ratios), 2, ["2", "3", "5"])]
    assert told == [describe_shares(["2", "3", "5"], len(ratios))]

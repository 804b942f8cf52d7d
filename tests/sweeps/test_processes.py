"""Processes that work side by side: cores of their own, and one that is killed costs the cells it ran and no others."""

import os
import signal
import time
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from sjdsl.sweeps import processes
from sjdsl.sweeps.processes import run_in_processes, shares_of


@pytest.mark.parametrize(
    ("cores", "workers", "shares"),
    [
        ([0, 1], 1, [(0, 1)]),
        ([0, 1], 2, [(0,), (1,)]),
        ([2, 3, 5, 7, 11], 2, [(2, 3), (5, 7, 11)]),
        ([0, 1, 2, 3, 4, 5, 6, 7], 3, [(0, 1), (2, 3, 4), (5, 6, 7)]),
        ([4, 5], 3, [(4, 5), (4, 5), (4, 5)]),
        ([], 2, [(), ()]),
    ],
)
def test_shares(cores: list[int], workers: int, shares: list[tuple[int, ...]]) -> None:
    assert shares_of(cores, workers) == shares


def run_beside_another(path: Path) -> None:
    """Stands in for `run_cell`: writes which cores it may use, and waits until two processes have; `killed` is killed by the system."""
    path.write_text(f"{os.getpid()} {sorted(os.sched_getaffinity(0)) if hasattr(os, 'sched_getaffinity') else ''}")
    if path.name == "killed":
        os.kill(os.getpid(), signal.SIGKILL)
    end = time.monotonic() + 60
    while len([*path.parent.iterdir()]) < 2 and time.monotonic() < end:
        time.sleep(0.01)


@pytest.fixture
def failed(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The names of the cells that have failed."""
    found: list[str] = []
    monkeypatch.setattr(processes, "run_cell", run_beside_another)
    monkeypatch.setattr(processes, "cell_at", lambda path: (Path(), {"episodes": 1}, SimpleNamespace(name=path.name)))
    monkeypatch.setattr(processes, "record_failure", lambda _, cell, __: found.append(cell.name))
    monkeypatch.setattr(processes, "progress_of", lambda *_: SimpleNamespace(state="stopped", summary="stopped"))
    return found


@pytest.mark.thorough
def test_processes_have_cores_of_their_own_and_one_that_is_killed_is_replaced(tmp_path: Path, failed: list[str]) -> None:
    told: list[str] = []
    run_in_processes([tmp_path / name for name in ("first", "killed", "second", "third")], 2, told.append)
    assert failed == ["killed"]
    assert sorted(told) == [f"{name}: stopped" for name in ("first", "killed", "second", "third")]
    seen: Any = {path.name: path.read_text().split(" ", 1) for path in tmp_path.iterdir()}
    assert seen.keys() == {"first", "killed", "second", "third"}
    assert seen["killed"][0] not in {seen[name][0] for name in ("first", "second", "third")}
    if hasattr(os, "sched_getaffinity") and len(os.sched_getaffinity(0)) > 1:
        assert seen["first"][1] != seen["killed"][1]

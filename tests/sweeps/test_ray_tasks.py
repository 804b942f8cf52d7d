"""How many tasks a sweep gives Ray at once, with a stand-in for Ray; the real one is in tests/interop."""

import sys
from collections.abc import Sequence
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest

from sjdsl.sweeps import engines
from sjdsl.sweeps.engines import Crew, run_batches

BATCHES = [(f"sweep/cells/{name}",) for name in "abcde"]


class Cluster(ModuleType):
    """Has room for any number of tasks, and ends the newest first."""

    exceptions = SimpleNamespace(WorkerCrashedError=InterruptedError, OutOfMemoryError=MemoryError)

    def __init__(self) -> None:
        super().__init__("ray")
        self.at_once: list[int] = []  # tasks that were there at each look
        self.done: list[Any] = []

    def is_initialized(self) -> bool:
        return True

    def cluster_resources(self) -> dict[str, float]:
        return {"CPU": 64.0}

    def remote(self, run: Any) -> Any:
        assert run is engines.run_cells
        task = SimpleNamespace(remote=lambda batch: batch)
        return SimpleNamespace(options=lambda **_: task)

    def wait(self, tasks: Sequence[Any], num_returns: int) -> tuple[list[Any], list[Any]]:
        assert num_returns == 1
        self.at_once.append(len(tasks))
        return [tasks[-1]], [*tasks[:-1]]

    def get(self, task: Any) -> None:
        self.done.append(task)


@pytest.mark.parametrize(
    ("workers", "at_once"), [(2, [2, 2, 2, 2, 1]), (1, [1, 1, 1, 1, 1]), (9, [5, 4, 3, 2, 1]), (None, [5, 4, 3, 2, 1])]
)
def test_at_most_so_many_tasks_as_workers(monkeypatch: pytest.MonkeyPatch, workers: int | None, at_once: list[int]) -> None:
    cluster = Cluster()
    monkeypatch.setitem(sys.modules, "ray", cluster)
    monkeypatch.setattr(engines, "_tell_states", lambda *_: None)
    run_batches(BATCHES, Crew("ray", workers=workers))
    assert cluster.at_once == at_once
    assert sorted(cluster.done) == BATCHES

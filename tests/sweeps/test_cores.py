"""Processes that work side by side have cores of their own."""

import os
import time
from pathlib import Path

import pytest

from sjdsl.sweeps.cores import processes, shares_of


@pytest.mark.parametrize(
    ("cores", "workers", "shares"),
    [
        ([0, 1], 1, [(0, 1)]),
        ([0, 1], 2, [(0,), (1,)]),
        ([2, 3, 5, 7, 11], 2, [(2, 3), (5, 7, 11)]),
        ([0, 1, 2, 3, 4, 5, 6, 7], 3, [(0, 1), (2, 3, 4), (5, 6, 7)]),
        ([4, 5], 3, [(4, 5), (4, 5), (4, 5)]),
    ],
)
def test_shares(cores: list[int], workers: int, shares: list[tuple[int, ...]]) -> None:
    assert shares_of(cores, workers) == shares


def cores_beside(folder: Path, others: int) -> set[int]:
    """Returns the cores that this process may use, when as many processes as are expected have asked."""
    (folder / str(os.getpid())).touch()
    end = time.monotonic() + 60
    while len([*folder.iterdir()]) < others and time.monotonic() < end:
        time.sleep(0.01)
    return os.sched_getaffinity(0)


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="the system does not let a process choose its cores")
def test_processes_have_cores_of_their_own(tmp_path: Path) -> None:
    ours = os.sched_getaffinity(0)
    if len(ours) < 2:
        pytest.skip("one core cannot be shared out")
    with processes(2) as pool:
        first, second = (future.result() for future in [pool.submit(cores_beside, tmp_path, 2) for _ in range(2)])
    assert first and second
    assert first.isdisjoint(second)
    assert first | second == ours
    assert os.sched_getaffinity(0) == ours

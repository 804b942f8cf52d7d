"""Processes that work side by side: cores and GPUs of their own, and one that is killed costs the cell it ran and no others."""

import os
import signal
import time
from pathlib import Path
from typing import Any

import pytest

from sjdsl.sweeps.processes import run_in_processes, shares_of
from sjdsl.sweeps.work import Watch

SEEN_AT_IMPORT = os.environ.get(
    "CUDA_VISIBLE_DEVICES", ""
)  # as JAX sees it, which is imported before a process runs any code of ours


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


def run_beside_another(path: Path, watch: Watch) -> None:
    """Stands in for `run_cell`: writes which GPU and cores it may use, and waits until two processes have; `killed` is killed by the system."""
    try:
        file = path.open("x")
    except FileExistsError:
        return  # another process has the cell
    with file:
        file.write(
            f"{os.getpid()} {SEEN_AT_IMPORT} {sorted(os.sched_getaffinity(0)) if hasattr(os, 'sched_getaffinity') else ''}"
        )
        file.flush()
    if path.name == "killed":
        os.kill(os.getpid(), signal.SIGKILL)
    end = time.monotonic() + 60
    while len([*path.parent.iterdir()]) < 2 and time.monotonic() < end:
        time.sleep(0.01)
    if path.name == "full":
        raise OSError("no room")
    watch.tell(f"{path.name}: done")


@pytest.mark.thorough
@pytest.mark.parametrize(("last", "whole"), [("killed", False), ("full", False), ("fourth", True)])
def test_processes_have_cores_of_their_own_and_one_that_ends_costs_no_other_cell(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], last: str, whole: bool
) -> None:
    names = [last, "first", "second", "third"]
    before = dict(os.environ)
    assert (
        run_in_processes([tmp_path / name for name in names], 2, ["4", "7"], run_beside_another)
        is whole
    )
    assert os.environ == before
    seen: Any = {path.name: path.read_text().split(" ", 2) for path in tmp_path.iterdir()}
    assert seen.keys() == {*names}
    assert {seen["first"][1], seen[last][1]} == {"4", "7"}
    told = capfd.readouterr().err.splitlines()
    assert {f"{name}: done" for name in ("first", "second", "third")} < {*told, ""}
    assert [line for line in told if last in line] == {
        "killed": [],
        "full": ["full: no room"],
        "fourth": ["fourth: done"],
    }[last]
    assert (seen[last][0] in {seen[name][0] for name in ("first", "second", "third")}) <= whole
    if hasattr(os, "sched_getaffinity") and len(os.sched_getaffinity(0)) > 1:
        assert seen["first"][2] != seen[last][2]

"""Sweeps whose process is killed, or that two processes work on, or that run out of room: the same results, and no cell twice."""

import csv
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.sweeps.described import GAME

SMALL = "num_envs=4 num_steps=4 num_minibatches=1 num_epochs=1 network=mlp network_width=4"
LONG = "total_timesteps=4800 checkpoint_updates=20"
SETS = " ".join(f"--set {text}" for text in f"{SMALL} {LONG}".split())
AXIS = "--axis reward=individual,common,exchange"
ARGUMENTS = f"sweep {GAME} {AXIS} {SETS} --seeds 2 --episodes 4 --run".split()
CELLS = [f"matrix_game_reward-{reward}" for reward in ("individual", "common", "exchange")]
PATIENCE = 400.0


def start(folder: Path, *more: str, limit: int = 0) -> "subprocess.Popen[str]":
    """Starts a sweep. `limit`: the bytes that a file may have, 0 for any number."""
    limits = (
        f"resource.setrlimit(resource.RLIMIT_FSIZE, ({limit}, resource.RLIM_INFINITY));"
        if limit
        else ""
    )
    program = (
        f"import resource, sys; {limits} from sjdsl.cli import main; sys.argv[0] = 'sjdsl'; main()"
    )
    variables = {**os.environ, "JAX_PLATFORMS": "cpu", "JAX_DISABLE_MOST_OPTIMIZATIONS": "true"}
    command = [sys.executable, "-c", program, *ARGUMENTS, str(folder), *more]
    return subprocess.Popen(
        command, env=variables, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )


def wait_for(condition: Callable[[], bool], process: "subprocess.Popen[str]") -> None:
    until = time.monotonic() + PATIENCE
    while not condition() and process.poll() is None:
        assert time.monotonic() < until
        time.sleep(0.002)


def rows_in(folder: Path, cell: str) -> int:
    lines = folder / "cells" / cell / "seed_1" / "metrics.jsonl"
    return lines.read_bytes().count(b"\n") if lines.exists() else 0


def results(folder: Path) -> bytes:
    return (folder / "results.csv").read_bytes()


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("whole") / "sweep"
    process = start(folder)
    assert process.wait(PATIENCE) == 0, process.communicate()[1][-3000:]
    assert [row["cell"] for row in csv.DictReader(results(folder).decode().splitlines())] == [
        cell for cell in CELLS for _ in range(2)
    ]
    return folder


@pytest.mark.parametrize(
    ("cell", "rows"),
    [
        pytest.param(1, 150, marks=pytest.mark.thorough),
        *(pytest.param(*at, marks=pytest.mark.slow) for at in ((0, 0), (0, 50), (2, 299))),
    ],
)
def test_kill_minus_nine(whole: Path, tmp_path: Path, cell: int, rows: int) -> None:
    """Killed when a cell has learnt so many updates of 300; at 0, when it has been locked."""
    folder = tmp_path / "sweep"
    process = start(folder)
    wait_for(
        lambda: (
            rows_in(folder, CELLS[cell]) >= rows
            if rows
            else (folder / "locks" / f"{CELLS[cell]}.lock").exists()
        ),
        process,
    )
    process.kill()
    process.communicate()
    assert process.returncode == -signal.SIGKILL
    again = start(folder)
    _, said = again.communicate(timeout=PATIENCE)
    assert again.returncode == 0, said[-3000:]
    assert results(folder) == results(whole)
    trained = [line for line in said.splitlines() if ": training" in line]
    assert len(trained) == 3 - cell, "what was done is kept"


@pytest.mark.thorough
def test_two_processes_on_one_folder(whole: Path, tmp_path: Path) -> None:
    folder = tmp_path / "sweep"
    both = [start(folder), start(folder)]
    said = [process.communicate(timeout=PATIENCE)[1] for process in both]
    assert [process.returncode for process in both] == [0, 0], said
    trained = sorted(
        line.partition(":")[0]
        for text in said
        for line in text.splitlines()
        if ": training" in line
    )
    assert trained == sorted(CELLS)
    assert results(folder) == results(whole)


@pytest.mark.slow
@pytest.mark.parametrize("limit", [3000, 20_000])
def test_a_full_disk(whole: Path, tmp_path: Path, limit: int) -> None:
    """The system refuses what goes beyond so many bytes of a file: `sweep.json`, and then the metrics of a run."""
    folder = tmp_path / "sweep"
    process = start(folder, limit=limit)
    _, said = process.communicate(timeout=PATIENCE)
    assert process.returncode == 1, said[-3000:]
    assert "Traceback" not in said
    assert "too large" in said.splitlines()[-1].lower()
    again = start(folder)
    _, said = again.communicate(timeout=PATIENCE)
    assert again.returncode == 0, said[-3000:]
    assert results(folder) == results(whole)

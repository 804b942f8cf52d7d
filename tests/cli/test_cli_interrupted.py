"""Ctrl-C and SIGTERM, while a command works or its processes start, end it with one line and status 130 or 143."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import psutil
import pytest
from command_line import INTERRUPTIBLE

from sjdsl.replay import Dataset

TRAIN = "train orchard.sj --preset two_cores --run run"
SWEEP = (
    "sweep orchard.sj --preset two_cores --axis reward=individual,common --workers 2 --run sweep"
)


@pytest.mark.thorough
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("call", [TRAIN, SWEEP])
def test_a_signal_ends_a_command_cleanly(call: str, number: signal.Signals, folder: Path) -> None:
    process = subprocess.Popen(
        [sys.executable, "-c", INTERRUPTIBLE, *call.split()],
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,  # Ctrl-C reaches all processes of a terminal
        env={**os.environ, "JAX_PLATFORMS": "cpu"},
    )
    assert process.stdout is not None
    said = ""
    if call is TRAIN:
        while "compiling" not in said:
            said = process.stdout.readline()
            assert said, "it ended before it compiled"
    else:
        while not psutil.Process(process.pid).children():
            time.sleep(0.05)
    time.sleep(0.5)
    os.killpg(process.pid, number)
    left = [line for line in process.stdout.read().splitlines() if line]
    assert process.wait(60) == 128 + number
    assert left[-1] == "interrupted"
    assert [line for line in left if line.startswith((" ", "Traceback", "Keyboard"))] == []


@pytest.mark.thorough
def test_sigterm_keeps_recorded_episodes(folder: Path) -> None:
    words = ["record", "orchard.sj", "--policy", "random", "--episodes", "1000000"]
    process = subprocess.Popen(
        [sys.executable, "-m", "sjdsl", *words],
        cwd=folder,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "JAX_PLATFORMS": "cpu"},
    )
    assert process.stderr is not None
    while "episodes written" not in process.stderr.readline():
        assert process.poll() is None
    process.terminate()
    assert process.stderr.read().splitlines()[-1] == "interrupted"
    assert process.wait(60) == 143
    assert len(Dataset(folder / "orchard.npz")) >= 100
    assert not list(folder.glob("*.unfinished"))

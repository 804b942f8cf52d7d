"""Ctrl-C while a command compiles, or while its processes start, ends it with one line and status 130."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import psutil
import pytest
from command_line import INTERRUPTIBLE

TRAIN = ("train", "orchard.sj", "--preset", "two_cores", "--run", "run")
SWEEP = ("sweep", "orchard.sj", "--preset", "two_cores", "--axis", "reward=individual,common", "--workers", "2", "--run", "sweep")


@pytest.mark.thorough
@pytest.mark.parametrize("words", [TRAIN, SWEEP], ids=lambda words: words[0])
def test_ctrl_c_ends_a_command_cleanly(words: tuple[str, ...], folder: Path) -> None:
    process = subprocess.Popen(
        [sys.executable, "-c", INTERRUPTIBLE, *words],
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,  # Ctrl-C reaches all processes of a terminal
        env={**os.environ, "JAX_PLATFORMS": "cpu"},
    )
    assert process.stdout is not None
    said = ""
    if words is TRAIN:
        while "compiling" not in said:
            said = process.stdout.readline()
            assert said, "it ended before it compiled"
    else:
        while not psutil.Process(process.pid).children():
            time.sleep(0.05)
    time.sleep(0.5)
    os.killpg(process.pid, signal.SIGINT)
    left = [line for line in process.stdout.read().splitlines() if line]
    assert process.wait(60) == 130
    assert left[-1] == "interrupted"
    assert [line for line in left if line.startswith((" ", "Traceback", "Keyboard"))] == []

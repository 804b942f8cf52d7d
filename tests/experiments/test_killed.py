"""A diagram whose process is killed goes on to the same files."""

import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from small_games import GOODS

ARGUMENTS = ["schelling", str(GOODS), "--cooperators", "stay", "--defectors", "random", "--episodes", "40", "-o"]
PATIENCE = 300.0


def start(folder: Path) -> "subprocess.Popen[str]":
    command = [sys.executable, "-m", "sjdsl", *ARGUMENTS, str(folder)]
    return subprocess.Popen(command, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)


@pytest.mark.slow
@pytest.mark.parametrize("parts", [0, 1, 3])
def test_kill_minus_nine(tmp_path: Path, parts: int) -> None:
    """Killed when so many line-ups are kept."""
    whole, killed = tmp_path / "whole", tmp_path / "killed"
    assert start(whole).wait(PATIENCE) == 0
    process, deadline = start(killed), time.monotonic() + PATIENCE
    wanted = killed / "parts" / f"lineup_{parts - 1:03d}_replicate_00.json" if parts else killed / "experiment.json"
    while not wanted.exists() and process.poll() is None:
        assert time.monotonic() < deadline
        time.sleep(0.002)
    process.kill()
    process.communicate()
    assert process.returncode == -signal.SIGKILL
    assert not (killed / "schelling.json").exists()
    assert start(killed).wait(PATIENCE) == 0
    for name in ("schelling.json", "schelling.png", "schelling.svg"):
        assert (killed / name).read_bytes() == (whole / name).read_bytes()

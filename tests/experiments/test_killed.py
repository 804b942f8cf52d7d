"""A diagram or a cross-play whose process is killed goes on to the same files; two processes at once do nothing twice."""

import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from small_games import GOODS

COMMANDS = {
    "schelling": ("--cooperators", "stay", "--defectors", "random"),
    "crossplay": ("--policies", "stay", "random", "--mix", "pairs"),
}
RESULTS = {
    "schelling": ("schelling.json", "schelling.png", "schelling.svg"),
    "crossplay": ("crossplay.csv", "crossplay.json", "matrix.png"),
}
LINEUPS = 4
PATIENCE = 300.0

pytestmark = pytest.mark.parametrize("command", COMMANDS)


def start(command: str, folder: Path) -> "subprocess.Popen[str]":
    arguments = [command, str(GOODS), *COMMANDS[command], "--episodes", "40", "-o", str(folder)]
    return subprocess.Popen([sys.executable, "-m", "sjdsl", *arguments], text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)


def files_of(command: str, folder: Path) -> dict[str, bytes]:
    return {name: (folder / name).read_bytes() for name in RESULTS[command]}


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> dict[str, dict[str, bytes]]:
    """The files of commands that nobody stopped."""
    found = {}
    for command in COMMANDS:
        folder = tmp_path_factory.mktemp("whole") / command
        assert start(command, folder).wait(PATIENCE) == 0
        found[command] = files_of(command, folder)
    return found


@pytest.mark.parametrize(
    "parts", [pytest.param(1, marks=pytest.mark.thorough), *(pytest.param(n, marks=pytest.mark.slow) for n in (0, LINEUPS - 1))]
)
def test_kill_minus_nine(tmp_path: Path, whole: dict[str, dict[str, bytes]], command: str, parts: int) -> None:
    """Killed when so many line-ups are kept."""
    killed = tmp_path / "killed"
    process, deadline = start(command, killed), time.monotonic() + PATIENCE
    wanted = killed / "parts" / f"lineup_{parts - 1:03d}_replicate_00.json" if parts else killed / "experiment.json"
    while not wanted.exists() and process.poll() is None:
        assert time.monotonic() < deadline
        time.sleep(0.002)
    process.kill()
    process.communicate()
    assert process.returncode == -signal.SIGKILL
    assert not (killed / RESULTS[command][-1]).exists()
    kept = len(list((killed / "parts").glob("*.json")))
    again = start(command, killed)
    said = again.communicate(timeout=PATIENCE)[1]
    assert again.returncode == 0, said
    assert said.count("playing 40 episodes") == LINEUPS - kept
    assert files_of(command, killed) == whole[command]


@pytest.mark.thorough
def test_two_processes_at_once(tmp_path: Path, whole: dict[str, dict[str, bytes]], command: str) -> None:
    """One of them plays everything; the other is refused in a line, or finds it done."""
    folder = tmp_path / "folder"
    both = [start(command, folder) for _ in range(2)]
    said = [process.communicate(timeout=PATIENCE)[1] for process in both]
    assert sum(text.count("playing 40 episodes") for text in said) == LINEUPS
    for process, text in zip(both, said, strict=True):
        assert process.returncode == 0 or (process.returncode == 1 and "is in use by process" in text.splitlines()[-1]), text
    assert min(process.returncode for process in both) == 0
    assert files_of(command, folder) == whole[command]

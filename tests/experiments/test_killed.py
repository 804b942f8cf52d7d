"""A diagram or a cross-play whose process is killed is played again to the same files; two processes at once write the same."""

import signal
import subprocess
import sys
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
PATIENCE = 300.0

pytestmark = pytest.mark.parametrize("command", COMMANDS)


def start(command: str, folder: Path) -> "subprocess.Popen[str]":
    arguments = [command, str(GOODS), *COMMANDS[command], "--episodes", "40", "-o", str(folder)]
    return subprocess.Popen(
        [sys.executable, "-m", "sjdsl", *arguments],
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )


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


@pytest.mark.thorough
def test_kill_minus_nine(tmp_path: Path, whole: dict[str, dict[str, bytes]], command: str) -> None:
    """Killed while it plays: nothing is written, and the same command writes everything."""
    killed = tmp_path / "killed"
    process = start(command, killed)
    assert process.stderr is not None
    assert any("line-up 2" in line for line in process.stderr)
    process.kill()
    process.communicate()
    assert process.returncode == -signal.SIGKILL
    assert not killed.exists()
    again = start(command, killed)
    said = again.communicate(timeout=PATIENCE)[1]
    assert again.returncode == 0, said
    assert files_of(command, killed) == whole[command]


@pytest.mark.thorough
def test_two_processes_at_once(
    tmp_path: Path, whole: dict[str, dict[str, bytes]], command: str
) -> None:
    both = [start(command, tmp_path / "folder") for _ in range(2)]
    said = [process.communicate(timeout=PATIENCE)[1] for process in both]
    assert [process.returncode for process in both] == [0, 0], said
    assert files_of(command, tmp_path / "folder") == whole[command]

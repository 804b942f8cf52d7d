"""`sjdsl play` in a real terminal: tmux is the terminal, keys are sent to it, what it shows is read back."""

import json
import os
import re
import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from tests.screen.conftest import ORCHARD

pytestmark = pytest.mark.skipif(shutil.which("tmux") is None, reason="tmux is not installed, and no other terminal can be driven from here")
PATIENCE = 60.0  # seconds until a test gives up


class Terminal:
    """A terminal of 100 x 30 letters and 256 colours, with a shell in it."""

    def __init__(self, folder: Path) -> None:
        self._socket = str(folder / "tmux")
        self._run("-f", "/dev/null", "new-session", "-d", "-x", "100", "-y", "30", "-c", str(folder), "env PS1='$ ' sh")

    def _run(self, *arguments: str) -> str:
        environment = {**os.environ, "TERM": "xterm-256color", "JAX_PLATFORMS": "cpu", "LC_ALL": "C.UTF-8"}
        done = subprocess.run(["tmux", "-S", self._socket, *arguments], env=environment, capture_output=True, text=True, check=True)
        return done.stdout

    def keys(self, *names: str) -> None:
        """Sends keys in one go, as tmux calls them."""
        self._run("send-keys", *names)

    def paste(self, text: str) -> None:
        """Pastes a text as terminals do for programs that ask to be told of it."""
        self._run("set-buffer", text)
        self._run("paste-buffer", "-p")

    def shown(self, colours: bool = False) -> str:
        """Returns what stands on the screen, with the codes that colour it if asked for."""
        return self._run("capture-pane", "-p", *(["-e"] if colours else []))

    def until(self, holds: Callable[[str], object]) -> str:
        """Returns the screen as soon as something holds of it."""
        end = time.monotonic() + PATIENCE
        while not holds(shown := self.shown()):
            assert time.monotonic() < end, shown
            time.sleep(0.05)
        return shown

    def close(self) -> None:
        self._run("kill-server")


@pytest.fixture
def terminal(tmp_path: Path) -> Iterator[Terminal]:
    shutil.copy(ORCHARD, tmp_path / "orchard.sj")
    opened = Terminal(tmp_path)
    yield opened
    opened.close()


def test_playing_by_keys(terminal: Terminal, tmp_path: Path) -> None:
    """Six quick arrows are six steps, pasted ones too; the colours differ; leaving restores the terminal and keeps the episode."""
    play = f"{sys.executable} -m sjdsl play orchard.sj --seed 3 --record episode.json"
    terminal.keys(f"stty -a > before; {play}; echo status $?; stty -a > after; echo 'all done'", "Enter")
    first = terminal.until(lambda shown: "step 0 of 12" in shown and "the agent you steer" in shown)  # a screen is drawn in parts
    assert "compiling in the background" in first, "the first picture does not wait for it"
    terminal.keys("Up", "Up", "Up", "Up", "Up", "Up")
    terminal.until(lambda shown: "step 6 of 12" in shown)
    terminal.paste("   ")
    terminal.until(lambda shown: "step 9 of 12" in shown)
    grounds = lambda: set(re.findall(r"48;5;(\d+)m", terminal.shown(colours=True)))  # noqa: E731
    terminal.until(lambda _: len(grounds()) >= 6)  # two kinds, two states of soil, two agents
    terminal.keys("q")
    left = terminal.until(lambda shown: "all done\n" in shown.replace("'all done'", ""))
    assert "status 0" in left
    assert "episode.json  9 steps of A Small Orchard" in left
    assert (tmp_path / "before").read_text() == (tmp_path / "after").read_text()
    kept = json.loads((tmp_path / "episode.json").read_text())
    assert [step[0] for step in kept["actions"]] == [2] * 6 + [3] * 3

"""No long silence: commands say what they are at, and what is wrong with a call is said before anything slow begins."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
from command_line import Sjdsl

from sjdsl.cli.stages import stages, status_line

WRONG = [
    (["train", "orchard.sj", "--preset", "papper"], "did you mean `paper`?"),
    (["train", "orchard.sj", "--set", "learning_rat=1"], "did you mean `learning_rate`?"),
    (["train", "orchard.sj", "--param", "aple=1"], "did you mean `apple`?"),
    (["train", "orchard.sj", "--variant", "rch"], "rch"),
    (["train", "orchard.sj", "--init-from", "runs/none"], "there is no policy `runs/none`"),
    (["train", "orchard.sj", "--partners", "1=randm"], "there is no policy `randm`"),
    (["check", "."], "`.` is a folder, and a game is wanted; name a file in it, such as orchard.sj"),
    (["train", "orchard.sj", "--run", "."], ". is not empty; name a new folder"),
    (["render", "orchard.sj", "--param", "aple=1"], "did you mean `apple`?"),
    (["render", "orchard.sj", "--policy", "randm"], "there is no policy `randm`"),
    (["play", "orchard.sj", "--watch", "--others", "randm"], "there is no policy `randm`"),
]
SCRIPT = """
import json, sys
from sjdsl.cli import run
for call in json.loads(sys.argv[1]):
    status = run(call)
    slow = [name for name in ("jax", "flax", "textual", "matplotlib", "hypothesis") if name in sys.modules]
    print(f"{' '.join(call)}: {status} {slow}")
"""


def test_a_mistyped_word_is_said_before_anything_slow_is_imported(folder: Path) -> None:
    """All calls in one process: what the first imports the last has, too."""
    calls = json.dumps([call for call, _ in WRONG])
    done = subprocess.run([sys.executable, "-c", SCRIPT, calls], cwd=folder, capture_output=True, text=True, check=True)
    assert [line.split(": ")[1] for line in done.stdout.splitlines()] == ["1 []"] * len(WRONG)
    for _, said in WRONG:
        assert said in done.stderr


def test_stages_are_lines_where_nobody_watches(capsys: pytest.CaptureFixture[str]) -> None:
    with stages("loading [red]") as say:
        say("playing")
    assert capsys.readouterr().err.splitlines() == ["loading [red]", "playing"]


def test_stages_have_their_time_on_a_terminal(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TTY_COMPATIBLE", "1")
    monkeypatch.setenv("TERM", "xterm")
    with stages("loading [red]") as say:
        say("playing")
    shown = capsys.readouterr().err
    assert "playing" in shown
    assert "0:00:00" in shown
    assert shown.endswith("\x1b[2K"), "the line vanishes"


def test_tests_say_what_they_are_at(sjdsl: Sjdsl) -> None:
    shown = sjdsl("test", "orchard.sj", "--examples", "1")
    assert "testing the checks of orchard.sj" in shown.err


def test_a_status_line_makes_room_for_what_is_printed(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TTY_COMPATIBLE", "1")
    monkeypatch.setenv("TERM", "xterm")
    with status_line("testing [red]") as status:
        status.show("trajectory 7 of 400")
        with status.hidden():
            print("a verdict")
            captured = capsys.readouterr()
        assert captured.out == "a verdict\n"
        assert "testing [red]: trajectory 7 of 400" in captured.err
        assert captured.err.endswith("\x1b[2K"), "the line is gone while the verdict is printed"
    assert capsys.readouterr().err.endswith("\x1b[2K"), "the line vanishes"


def test_a_status_line_makes_no_noise_elsewhere(capsys: pytest.CaptureFixture[str]) -> None:
    with status_line("testing [red]") as status:
        status.show("trajectory 7 of 400")
        with status.hidden():
            print("a verdict")
    assert capsys.readouterr() == ("a verdict\n", "testing [red]\n")

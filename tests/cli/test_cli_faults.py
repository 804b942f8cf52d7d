"""Mistakes in a command line: one line each, with what was probably meant, and never a traceback."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from command_line import Sjdsl

from sjdsl.cli import check, run
from sjdsl.library.games_folder import find_game


def test_an_interrupt_is_one_line(sjdsl: Sjdsl, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(check, "open_game", interrupted)
    shown = sjdsl("check", "orchard.sj")
    assert shown.status == 130
    assert shown.text.split() == ["interrupted"]


def test_a_mistake_of_ours_keeps_its_traceback(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    del folder
    monkeypatch.setattr(check, "open_game", lambda _: {}["x"])
    with pytest.raises(KeyError):
        run(["check", "orchard.sj"])


def test_help_lists_the_commands_without_importing_them() -> None:
    program = (
        "import sys; from sjdsl.cli import run; run(['--help']); "
        "assert 'jax' not in sys.modules; assert 'sjdsl.compiler' not in sys.modules"
    )
    shown = subprocess.run(
        [sys.executable, "-c", program], check=True, capture_output=True, text=True
    ).stdout
    for name in (
        "check",
        "compile",
        "dump",
        "explain",
        "list",
        "bench",
        "render",
        "train",
        "evaluate",
    ):
        assert name in shown


def test_no_help_and_nothing_that_only_reads_a_game_waits_for_jax(tmp_path: Path) -> None:
    (tmp_path / "coins.sj").write_text(find_game("coins").read_text())
    calls = [
        "check coins",
        "fmt coins.sj",
        "doc coins",
        "diff coins pd_arena",
        "trace coins --steps 2 --param length=9",
        "list",
        "explain SJ101",
    ]
    program = (
        "import sys; from sjdsl.cli import COMMANDS, run\n"
        f"assert not any(run([name, '--help']) for name in COMMANDS); assert not any(run(call.split()) for call in {calls})\n"
        "assert not {'jax', 'flax', 'matplotlib', 'hypothesis'} & set(sys.modules), set(sys.modules)"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], check=False, capture_output=True, text=True, cwd=tmp_path
    )
    assert done.returncode == 0, done.stderr


def test_the_package_runs_as_a_module() -> None:
    shown = subprocess.run(
        [sys.executable, "-m", "sjdsl", "--version"], check=True, capture_output=True, text=True
    )
    assert shown.stdout.startswith("sjdsl ")


@pytest.mark.skipif(sys.platform == "win32", reason="there is no such pipe")
@pytest.mark.parametrize("arguments", ["check game.sj", "list", "--help"])
def test_a_reader_that_has_closed_gets_no_traceback(arguments: str, tmp_path: Path) -> None:
    """As with `sjdsl check game.sj | head`: the command ends without a word on the standard error."""
    (tmp_path / "game.sj").write_text("sj 1\ngame game {\n  kind\n}\n")
    program = "import sys; sys.argv[0] = 'sjdsl'; from sjdsl.cli import main; main()"
    read, write = os.pipe()
    os.close(read)
    done = subprocess.run(
        [sys.executable, "-c", program, *arguments.split()],
        cwd=tmp_path,
        stdout=write,
        stderr=subprocess.PIPE,
        check=False,
    )
    os.close(write)
    assert (done.returncode, done.stderr) == (1, b"")


def test_a_message_does_not_control_the_terminal(sjdsl: Sjdsl, folder: Path) -> None:
    (folder / "mine.toml").write_text('game = "\\u001b]0;owned\\u0007\\u009b31m"\n')
    shown = sjdsl("train", "--preset", "mine.toml")
    assert shown.status == 1
    assert "\\x1b]0;owned\\x07\\x9b31m" in shown.err

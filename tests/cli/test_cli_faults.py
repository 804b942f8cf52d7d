"""Mistakes in a command line: one line each, with what was probably meant, and never a traceback."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from command_line import GAME, Sjdsl

from sjdsl.cli import check, run


def test_an_interrupt_is_one_line(sjdsl: Sjdsl, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(check, "open_game", interrupted)
    shown = sjdsl("check orchard.sj")
    assert shown.status == 130
    assert shown.text.split() == ["interrupted"]


def test_a_mistake_of_ours_keeps_its_traceback(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    del folder
    monkeypatch.setattr(check, "open_game", lambda _: {}["x"])
    with pytest.raises(KeyError):
        run(["check", "orchard.sj"])


def test_no_help_and_nothing_that_only_reads_a_game_waits_for_jax(tmp_path: Path) -> None:
    """`test_transcripts.py` says the same of `check`, `compile`, `diff`, `trace` and `explain`."""
    (tmp_path / "orchard.sj").write_text(GAME)
    program = (
        "import sys; from sjdsl.cli import COMMANDS, run\n"
        "assert not run(['--help']) and 'sjdsl.compiler' not in sys.modules\n"
        "assert not any(run([name, '--help']) for name in COMMANDS)\n"
        "assert not any(run([name, 'orchard.sj']) for name in ('fmt', 'doc'))\n"
        "assert not {'jax', 'flax', 'matplotlib', 'hypothesis'} & set(sys.modules), set(sys.modules)"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], check=False, capture_output=True, text=True, cwd=tmp_path
    )
    assert done.returncode == 0, done.stderr


@pytest.mark.skipif(sys.platform == "win32", reason="there is no such pipe")
@pytest.mark.parametrize("arguments", ["check game.sj", "--help"])
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

"""A folder with a small game, and a way to run the command line in it."""

import shlex
from pathlib import Path

import pytest
from command_line import GAME, GROVE, Output, Sjdsl

from sjdsl.cli import run


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, empty but for `orchard.sj`."""
    (tmp_path / "orchard.sj").write_text(GAME)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def grove(folder: Path) -> None:
    """`grove.sj` beside it, which has a policy and scenarios."""
    (folder / "grove.sj").write_text(GROVE)


@pytest.fixture
def sjdsl(folder: Path, capsys: pytest.CaptureFixture[str]) -> Sjdsl:
    """Runs `sjdsl` in the folder: with words as one types them, and further arguments as they are."""
    del folder

    def call(typed: str, *arguments: str | Path) -> Output:
        status = run([*shlex.split(typed), *map(str, arguments)])
        return Output(status, *capsys.readouterr())

    return call

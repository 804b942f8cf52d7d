"""A folder with a small game, and a way to run the command line in it."""

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
    """Runs `sjdsl` with arguments in the folder."""
    del folder

    def call(*arguments: str | Path) -> Output:
        status = run([str(argument) for argument in arguments])
        return Output(status, *capsys.readouterr())

    return call

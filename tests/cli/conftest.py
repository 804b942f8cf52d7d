"""A folder with a small game, and a way to run the command line in it."""

import shlex
from collections.abc import Iterator
from pathlib import Path

import pytest
from command_line import GAME, GROVE, Output, Sjdsl
from luna import KEY, by_role, write_models

from sjdsl.cli import run
from tests.models.server import Server, serving


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


@pytest.fixture
def server(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Server]:
    """A server of the model `luna`, whose file is in the working folder."""
    monkeypatch.setenv("LUNA_KEY", KEY)
    with serving(Server(by_role)) as running:
        write_models(folder, running.url)
        yield running

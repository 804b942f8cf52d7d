"""Text for terminals and files whose encoding lacks some of its characters."""

import io
import os
import subprocess
import sys

import click
import pytest
from command_line import GAME

from sjdsl.cli.encoding import accept_any_text

TITLE = "Jardín ガ … ½ ≠"


@pytest.mark.parametrize(
    ("encoding", "shown"),
    [
        ("utf-8", TITLE),
        ("latin-1", r"Jardín \u30ac ... ½ \u2260"),
        ("cp1252", r"Jardín \u30ac … ½ \u2260"),
        ("cp437", r"Jardín \u30ac ... ½ \u2260"),
        ("ascii", r"Jardin \u30ac ... \xbd \u2260"),
        ("shift_jis", r"Jardin ガ … \xbd ≠"),
    ],
)
@pytest.mark.parametrize("name", ["stdout", "stderr"])
def test_what_an_encoding_lacks_is_spelt(
    name: str, encoding: str, shown: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    written = io.BytesIO()
    monkeypatch.setattr(sys, name, io.TextIOWrapper(written, encoding, newline="\n"))
    accept_any_text()
    click.echo(TITLE, err=name == "stderr")
    assert written.getvalue().decode(encoding) == shown + "\n"


@pytest.mark.parametrize(
    ("arguments", "encoding"),
    [
        (["train", "--help"], "ascii"),
        (["doc", "garden.sj"], "latin-1"),
        (["check", "mistake.sj"], "ascii"),
    ],
)
def test_commands_print_in_any_encoding(
    arguments: list[str], encoding: str, tmp_path_factory: pytest.TempPathFactory
) -> None:
    folder = tmp_path_factory.mktemp("games")
    garden = GAME.replace("A Small Orchard", TITLE)
    (folder / "garden.sj").write_text(garden, encoding="utf-8")
    (folder / "mistake.sj").write_text(
        garden.replace("phase walk", "if # … ガ\n phase walk"), encoding="utf-8"
    )
    command = [sys.executable, "-m", "sjdsl", *arguments]
    ran = subprocess.run(
        command, cwd=folder, capture_output=True, env=os.environ | {"PYTHONIOENCODING": encoding}
    )
    assert ran.stderr == b""
    assert ran.returncode == (1 if "mistake.sj" in arguments else 0)
    assert "..." in ran.stdout.decode(encoding)


def test_a_formatted_game_keeps_its_characters() -> None:
    game = GAME.replace("A Small Orchard", TITLE).encode()
    command = [sys.executable, "-m", "sjdsl", "fmt", "-"]
    ran = subprocess.run(
        command, input=game, capture_output=True, env=os.environ | {"PYTHONIOENCODING": "ascii"}
    )
    assert TITLE.encode() in ran.stdout

"""docs/models.md tells the truth: its file of models, its Python lines, its figures and its commands,
with the model of the page that costs nothing."""

import re
import shlex
from pathlib import Path
from typing import Any

import click
import jax
import numpy as np
import pytest

from sjdsl.cli import commands, run
from sjdsl.models import Message, load_models

ROOT = Path(__file__).parent.parent
PAGE = (ROOT / "docs/models.md").read_text(encoding="utf-8")
MATRIX = ROOT / "tests/experiments/games/matrix_game.sj"


def blocks(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", PAGE, re.DOTALL)


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A working folder with the page's file of models."""
    monkeypatch.chdir(tmp_path)
    (table,) = blocks("toml")
    Path("models.toml").write_text(table)


def test_the_diagram_in_python() -> None:
    """In a game of four steps, played by the model `dry` of the page."""
    diagram, *_ = blocks("python")
    lines = diagram.replace('"clean_up"', repr(str(MATRIX))).replace('"luna"', '"dry"')
    exec(lines, {})
    assert Path("d/schelling.json").is_file()
    assert load_models("models.toml")["luna"].model


def test_a_policy_of_ones_own() -> None:
    names: dict[str, Any] = {}
    exec(blocks("python")[1], names)
    cautious = names["Cautious"]()
    actions = ("stay", "forward")
    for seen, action in (("forward -> grass", "forward"), ("forward -> water", "stay")):
        assert cautious.decide(0, Message("", seen, actions, actions)).action == action


def test_what_is_told_in_python(capsys: pytest.CaptureFixture[str]) -> None:
    """The line in the comment, too."""
    names: dict[str, Any] = {"np": np}
    exec(blocks("python")[2], names)
    assert "reward of 2." in capsys.readouterr().out
    observation, state = names["env"].reset(jax.random.key(0))
    call = re.search(r"^# (message\(.*\))$", blocks("python")[2], re.MULTILINE)
    assert call is not None
    text = eval(call[1], names | {"observation": observation, "state": state})
    assert text.startswith("YOUR LAST REWARD: 0\n")


def test_the_figures_of_the_dry_run(capsys: pytest.CaptureFixture[str]) -> None:
    (command,) = re.findall(r"^sjdsl (schelling .*)$", PAGE, re.MULTILINE)
    assert run(shlex.split(command)) == 0
    shown = capsys.readouterr().out.splitlines()[0]
    assert f"\n{shown}\n" in PAGE


def test_the_commands_of_the_table() -> None:
    """With options that there are; nothing is run."""
    above = click.Context(commands, info_name="sjdsl")
    lines = re.findall(r"^\| `(\w+ [^`]+)` \|", PAGE, re.MULTILINE)
    assert len(lines) > 5
    for line in lines:
        name, *arguments = shlex.split(line)
        command = commands.get_command(above, name)
        assert command is not None, name
        command.make_context(name, arguments, parent=above)

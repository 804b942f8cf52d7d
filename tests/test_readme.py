"""The README tells the truth: its game compiles and plays, its Python lines run."""

import re
import shlex
from pathlib import Path
from typing import Any

import click
import jax
import numpy as np
import pytest

import sjdsl
from sjdsl import Environment
from sjdsl.cli import commands
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.format import format_source

ROOT = Path(__file__).parent.parent
FIGURE = r"-?[\d.,]+ \[(-?[\d.,]+, -?[\d.,]+|not known)\]"  # with its interval


def block(language: str, page: str = "README.md") -> str:
    """Returns the first fenced block of a language."""
    found = re.search(
        rf"```{language}\n(.*?)```", (ROOT / page).read_text(encoding="utf-8"), re.DOTALL
    )
    assert found is not None, language
    return found.group(1)


def walked(env: Environment) -> tuple[np.ndarray, Any]:
    """Returns the rewards of 30 steps in which everybody walks on, `[30, N]`, and the last state."""
    _, state = env.reset(jax.random.key(0))
    forward = jax.numpy.full(env.num_agents, env.action_names.index("forward"))
    rewards = []
    for i in range(30):
        _, state, reward, _, _ = env.step(jax.random.key(i), state, forward)
        rewards.append(np.asarray(reward))
    return np.stack(rewards), state


def test_the_orchard_is_the_example_and_plays() -> None:
    path = ROOT / "examples" / "orchard.sj"
    text = path.read_text(encoding="utf-8")
    assert all(f"  {line}\n" in text for line in block("sj").splitlines())
    assert format_source(Source("orchard.sj", text)) == text
    assert sjdsl.make(path, num_agents=6).num_agents == 6  # as many as its limits allow
    env = sjdsl.make(path, params={"regrow": 0})
    rewards, state = walked(env)
    assert rewards.sum() == 16 - int((state.tree_fruit == 1).sum())


def test_the_changed_line_shares_each_fruit(tmp_path: Path) -> None:
    (removed,), (added,) = (
        re.findall(rf"^[{sign}] +(.*)$", block("diff"), re.MULTILINE) for sign in "-+"
    )
    text = (ROOT / "examples" / "orchard.sj").read_text(encoding="utf-8")
    assert text.count(f" {removed}\n") == 1
    path = tmp_path / "shared.sj"
    path.write_text(text.replace(removed, added), encoding="utf-8")
    rewards, _ = walked(sjdsl.make(path))
    assert (rewards == rewards[:, :1]).all()
    assert rewards.sum() > 0


def test_the_python_lines() -> None:
    names: dict = {}
    exec(block("python"), names)
    assert names["observation"].shape == names["env"].observation_shape


@pytest.mark.slow
def test_the_python_lines_of_training(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    exec(block("python", "docs/training.md"), {})
    assert re.search(FIGURE, capsys.readouterr().out)


@pytest.mark.slow
def test_the_python_lines_of_playing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    names: dict = {}
    for lines in re.findall(
        r"```python\n(.*?)```", (ROOT / "docs/playing.md").read_text("utf-8"), re.DOTALL
    ):
        exec(lines, names)
    assert len(names["player"].actions) == 1000
    assert names["moment"].done


@pytest.mark.slow
def test_the_python_lines_of_experiments(capsys: pytest.CaptureFixture[str]) -> None:
    exec(block("python", "docs/experiments.md"), {})
    assert re.search(FIGURE, capsys.readouterr().out)


def shown_commands() -> list[tuple[str, str]]:
    """Returns the lines of fenced blocks of all pages that call `sjdsl`, each with its page."""
    found = []
    for page in [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]:
        blocks = re.split(r"^```.*\n", page.read_text("utf-8"), flags=re.MULTILINE)[1::2]
        found += [
            (page.name, line)
            for block in blocks
            for line in block.splitlines()
            if line.startswith("sjdsl ")
        ]
    return found


def test_the_commands_of_the_pages_are_commands() -> None:
    """With options that there are; nothing is run."""
    above, wrong = click.Context(commands, info_name="sjdsl"), []
    assert len(shown_commands()) > 30
    for page, line in shown_commands():
        name, *arguments = shlex.split(line, comments=True)[1:]
        command = commands.get_command(above, name)
        try:
            assert command is not None, f"there is no command {name}"
            command.make_context(name, arguments, parent=above)
        except (AssertionError, click.ClickException) as error:
            wrong.append((page, line, str(error)))
    assert wrong == []

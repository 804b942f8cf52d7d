"""docs/own_algorithms.md: its files fit the trainers, its commands run, and opponent shaping works."""

import re
import shlex
from itertools import pairwise
from pathlib import Path
from typing import Any

import jax
import pytest
from probes import QUICK, matching
from run_outcomes import read_lines, read_manifest

import sjdsl
from sjdsl.cli import run as command_line
from sjdsl.trainers import make_config, make_train
from sjdsl.trainers.settings.own_settings import filled

PAGE = (Path(__file__).parents[2] / "docs" / "own_algorithms.md").read_text(encoding="utf-8")
FILES = dict(re.findall(r'```\w+ title="([\w.]+)"\n(.*?)```', PAGE, re.DOTALL))
COMMANDS = [shlex.split(line) for line in PAGE.splitlines() if line.startswith("sjdsl ")]
SMALL = {**QUICK, "num_envs": 2, "num_steps": 4, "total_timesteps": 8 * 2}
PER_AGENT = {"sharing": "per_agent", "mask_actions": False}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    for name, text in FILES.items():
        (tmp_path / name).write_text(text)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize(
    ("values", "column"),
    [
        ({"loss": "penalised.py:penalised", "own": {"penalty": 2}}, "penalty"),
        ({"algorithm": "curiosity.py:curious", "own": {"bonus": 1}}, "surprise"),
        ({"algorithm": "lola.py:lola", "own": {"lookahead": 0.1}, **PER_AGENT}, "loss"),
    ],
)
def test_the_files_fit_the_trainers(values: dict[str, Any], column: str) -> None:
    config = make_config(SMALL, **values)
    program = make_train(matching(), config)
    before = jax.eval_shape(program.init, jax.random.key(0))
    after, metrics = jax.eval_shape(program.update, before)
    assert jax.tree.map(lambda leaf: (leaf.shape, leaf.dtype), after) == jax.tree.map(
        lambda leaf: (leaf.shape, leaf.dtype), before
    )
    assert metrics[column].shape == ()


def smaller(command: list[str]) -> list[str]:
    """Returns a command of the page with few and short rollouts."""
    few = {
        "num_envs": 2,
        "num_steps": 8,
        "num_minibatches": 1,
        "num_epochs": 1,
        "network": "mlp",
        "network_width": 8,
        "total_timesteps": 48,
    }
    kept = [
        part
        for pair in pairwise(command)
        if pair[0] == "--set"
        for part in pair
        if pair[1].split("=")[0] not in few
    ]
    others = [
        part
        for index, part in enumerate(command)
        if part != "--set" and command[index - 1] != "--set"
    ]
    sets = [part for name, value in few.items() for part in ("--set", f"{name}={value}")]
    return [
        *others[1:],
        *kept,
        *sets,
        *(["--param", "length=8"] if "again.sj" not in command else []),
        "--episodes",
        "1",
    ]


@pytest.mark.thorough
@pytest.mark.parametrize(
    "command",
    [
        command
        for command in COMMANDS
        if command[1] == "train" and not {"--keys", "--resume"} & {*command}
    ],
    ids=lambda command: command[2],
)
def test_the_commands_train(command: list[str], folder: Path) -> None:
    run_dir = ["--run", "run"] if "--run" not in command else []
    with jax.debug_key_reuse(False):
        assert command_line([*smaller(command), *run_dir]) == 0
    (manifest,) = folder.glob("**/manifest.json")
    assert read_manifest(manifest.parent)["status"] == "finished"
    assert len(read_lines(manifest.parent / "metrics.jsonl")) == 3


@pytest.mark.thorough
@pytest.mark.usefixtures("folder")
def test_agents_that_expect_each_other_to_learn_cooperate() -> None:
    """In an episode of 16 steps two who always betray earn 16 each, and two who never do 48."""
    env = sjdsl.make("again.sj")
    (command,) = (
        command for command in COMMANDS if "lola.py:lola" in command and command[1] == "train"
    )
    values = dict(
        part.split("=") for part in command if "=" in part and not part.startswith("own.")
    )
    config = make_config(values, algorithm="lola.py:lola").model_copy(update={"algorithm": "ippo"})
    learner = filled("algorithm", "lola.py:lola", ())

    @jax.jit
    def last_returns(lookahead: float) -> jax.Array:
        program = learner(env, config, lookahead=lookahead)
        _, metrics = jax.lax.scan(
            lambda state, _: program.update(state), program.init(jax.random.key(0)), length=200
        )
        return metrics["agent_return"][-20:].mean(axis=0)

    with jax.debug_key_reuse(False):
        assert last_returns(0.0).max() < 18
        assert last_returns(0.03).min() > 40

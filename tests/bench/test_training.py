"""Where an update of training spends its time: the parts are all there, and the network's operations are those of its matrices."""

import json
from dataclasses import asdict
from pathlib import Path

import pytest

from sjdsl.bench import Training, measure_training
from sjdsl.bench.tables import training_table
from sjdsl.cli import run
from sjdsl.runtime.env import Environment

ENVS, STEPS, WIDTH = 4, 8, 64


@pytest.fixture(scope="module")
def training(meadow_env: Environment) -> Training:
    return measure_training([meadow_env], ["mlp"], ENVS, STEPS, repeats=2)


@pytest.mark.slow
def test_every_part_is_timed_in_every_round(training: Training) -> None:
    (split,) = training.splits
    for seconds in (split.update, split.environments, split.rollout, split.learning):
        assert len(seconds) == 2
        assert min(seconds) > 0
    assert split.compile_s > 0
    assert training.flops_per_s > 0
    assert json.loads(json.dumps(asdict(training)))["splits"][0]["network"] == "mlp"


@pytest.mark.slow
def test_operations_are_those_of_the_matrices(training: Training, meadow_env: Environment) -> None:
    """Forward: 2 operations an entry of each matrix and sample. A gradient step: forward, and twice that backward, but for the inputs."""
    inputs = len(meadow_env.channel_names) * 2 * 3
    entries = inputs * WIDTH + 2 * WIDTH * WIDTH + WIDTH * (meadow_env.num_actions + 1)
    samples = ENVS * STEPS * meadow_env.num_agents
    forward = 2 * entries * ENVS * meadow_env.num_agents * (STEPS + 1)
    backward = 2 * (3 * entries - inputs * WIDTH) * samples * 2  # epochs
    assert training.splits[0].flops == pytest.approx(forward + backward, rel=0.1)


@pytest.mark.slow
def test_the_table_has_the_parts(training: Training) -> None:
    table = training_table(training)
    assert all(len(row) == len(table.headings) for row in table.rows)
    assert table.rows[0][:3] == ("meadow", "2", "mlp")


@pytest.mark.slow
def test_on_the_command_line(meadow: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    figures = tmp_path / "figures.json"
    assert run(["bench", str(meadow), "--training", "mlp", "--envs", "2", "--steps", "4", "--repeats", "1", "--json", str(figures)]) == 0
    assert "one update of IPPO: 2 environments, 4 steps" in capsys.readouterr().out
    assert json.loads(figures.read_text())["splits"][0]["num_steps"] == 4


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (["--training", "rnn"], "`rnn` is not `mlp`, `cnn` or `mlp,cnn`"),
        (["--training", "mlp", "--observation", "onehot"], "training is measured with tokens"),
        (["--training", "mlp", "--envs", "1,2"], "at one number of environments"),
        (["--training", "mlp", "--sweep", "apple"], "one at a time"),
    ],
)
def test_what_does_not_fit_is_refused(meadow: Path, capsys: pytest.CaptureFixture[str], wrong: list[str], message: str) -> None:
    assert run(["bench", str(meadow), *wrong]) == 2
    assert message in capsys.readouterr().err

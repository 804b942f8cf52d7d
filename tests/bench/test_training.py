"""Where an update of training spends its time: the parts are all there, and the network's operations are those of its matrices."""

import json
from pathlib import Path

import pytest

import sjdsl
from sjdsl.bench import Training, measure_training
from sjdsl.bench.tables import training_table
from sjdsl.cli import run
from sjdsl.runtime.env import Environment

GAME = """sj 1
game meadow "Meadow" {
  episode 3
  kind soil "A" { field fruit : { none, ripe } = ripe }
  map { "AAA" }
  agents 2 { acts forward, stay  moves relative }
  phase start { each agent { send agent to soil } }
  schedule walk -> eat
  phase walk { move each agent }
  phase eat { each agent on soil where soil.fruit is ripe { set soil.fruit = none  give 1 to agent } }
  observe { window ahead 2, behind 0, left 1, right 1 }
}
"""
ENVS, STEPS, WIDTH = 4, 8, 64


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("games") / "meadow.sj"
    path.write_text(GAME)
    return path


@pytest.fixture(scope="module")
def env(file: Path) -> Environment:
    return sjdsl.make(file)


@pytest.fixture(scope="module")
def training(env: Environment) -> Training:
    return measure_training([env], ["mlp"], ENVS, STEPS, repeats=2)


def test_every_part_is_timed_in_every_round(training: Training) -> None:
    (split,) = training.splits
    for seconds in (split.update, split.environments, split.rollout, split.learning):
        assert len(seconds) == 2
        assert min(seconds) > 0
    assert split.compile_s > 0
    assert training.flops_per_s > 0
    assert json.loads(json.dumps(training.to_json()))["splits"][0]["network"] == "mlp"


def test_operations_are_those_of_the_matrices(training: Training, env: Environment) -> None:
    """Forward: 2 operations an entry of each matrix and sample. A gradient step: forward, and twice that backward, but for the inputs."""
    inputs = len(env.channel_names) * 3 * 3
    entries = inputs * WIDTH + 2 * WIDTH * WIDTH + WIDTH * (env.num_actions + 1)
    samples = ENVS * STEPS * env.num_agents
    forward = 2 * entries * ENVS * env.num_agents * (STEPS + 1)
    backward = 2 * (3 * entries - inputs * WIDTH) * samples * 2  # epochs
    assert training.splits[0].flops == pytest.approx(forward + backward, rel=0.1)


def test_the_table_has_the_parts(training: Training) -> None:
    table = training_table(training)
    assert all(len(row) == len(table.headings) for row in table.rows)
    assert table.rows[0][:3] == ("Meadow".lower(), "2", "mlp")


def test_on_the_command_line(file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    figures = tmp_path / "figures.json"
    assert run(["bench", str(file), "--training", "mlp", "--envs", "2", "--steps", "4", "--repeats", "1", "--json", str(figures)]) == 0
    assert "one update of IPPO: 2 environments, 4 steps" in capsys.readouterr().out
    assert json.loads(figures.read_text())["splits"][0]["num_steps"] == 4


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (["--training", "rnn"], "`rnn` is not `mlp`, `cnn` or `mlp,cnn`"),
        (["--training", "mlp", "--observation", "onehot"], "training is measured with tokens"),
        (["--training", "mlp", "--envs", "1,2"], "at one number of environments"),
    ],
)
def test_what_does_not_fit_is_refused(file: Path, capsys: pytest.CaptureFixture[str], wrong: list[str], message: str) -> None:
    assert run(["bench", str(file), *wrong]) == 2
    assert message in capsys.readouterr().err

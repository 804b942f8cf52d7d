"""Where an update of training spends its time: the parts are all there, and the network's operations are those of its matrices."""

import json
from dataclasses import asdict
from pathlib import Path

import jax
import pytest
from click.testing import CliRunner

from bench.speed.__main__ import main
from bench.speed.stored import read_figures
from bench.speed.tables import tables_of, training_table
from bench.speed.training import (
    Split,
    Training,
    flops_of,
    idle_rollout,
    measure_training,
    training_setups,
)
from sjdsl.runtime.env import Environment
from sjdsl.trainers import make_train

ENVS, STEPS, WIDTH = 4, 8, 64
LEARNERS = [
    ("ippo", "shared"),
    ("ippo", "per_agent"),
    ("mappo", "shared"),
    ("mappo", "per_agent"),
    ("vdn", "shared"),
]


@pytest.fixture(scope="module")
def training(meadow_env: Environment) -> Training:
    setups, refused = training_setups(
        [(meadow_env.name, meadow_env)], ["mlp"], ["ippo", "vdn"], num_envs=ENVS, num_steps=STEPS
    )
    return measure_training(setups, repeats=2, env_steps=10**6, left_out=refused)


@pytest.mark.slow
def test_every_part_is_timed_in_every_round(training: Training) -> None:
    assert [(split.algorithm, split.sharing) for split in training.splits] == [
        ("ippo", "shared"),
        ("vdn", "shared"),
    ]
    for split in training.splits:
        for seconds in (split.update, split.environments, split.rollout, split.learning):
            assert len(seconds) == 2
            assert min(seconds) > 0
        assert split.compile_s > 0
    assert training.flops_per_s > 0
    assert json.loads(json.dumps(asdict(training)))["splits"][0]["network"] == "mlp"


def matrices(env: Environment) -> tuple[int, int]:
    """Returns the entries of the layer that reads a window, and of a hidden layer of a head."""
    inputs = len(env.channel_names) * 2 * 3
    return inputs * WIDTH, WIDTH * WIDTH


def operations(samples: int, first: int, rest: int, gradient: bool) -> int:
    """Forward: 2 operations an entry of each matrix and sample. With the gradient twice that more, but for the inputs."""
    return 2 * samples * (3 * (first + rest) - first if gradient else first + rest)


@pytest.mark.parametrize(("algorithm", "sharing"), LEARNERS)
def test_operations_are_those_of_the_matrices(
    meadow_env: Environment, algorithm: str, sharing: str
) -> None:
    """Who shares does not matter. Of mappo the critic is a network of its own that sees the windows of both agents."""
    (setup,), _ = training_setups(
        [(meadow_env.name, meadow_env)], ["mlp"], [algorithm], [sharing], ENVS, STEPS
    )
    program = make_train(meadow_env, setup.config)
    parameters = program.parameters(jax.eval_shape(program.init, jax.random.key(0)))
    first, hidden = matrices(meadow_env)
    actions, agents = meadow_env.num_actions, meadow_env.num_agents
    if algorithm == "ippo":
        sides = [(first, 2 * hidden + WIDTH * (actions + 1), agents)]
    else:
        sides = [(first, hidden + WIDTH * actions, agents)]
    if algorithm == "mappo":
        critics = 1 if sharing == "shared" else agents
        sides += [(agents * first, hidden + WIDTH * agents // critics, critics)]
    expected = 0
    for own, rest, each in sides:
        if algorithm == "vdn":
            expected += operations(ENVS * STEPS * each, own, rest, False)
            expected += 4 * sum(
                operations(128 * each, own, rest, gradient) for gradient in (True, False)
            )  # the target has no gradient
        else:
            expected += operations(ENVS * (STEPS + 1) * each, own, rest, False)
            expected += 2 * operations(ENVS * STEPS * each, own, rest, True)  # epochs
    assert flops_of(meadow_env, setup.config, parameters) == pytest.approx(expected, rel=0.1)


@pytest.mark.parametrize("algorithm", ["ippo", "vdn"])
def test_a_rollout_without_a_network_has_the_same_steps(
    meadow_env: Environment, algorithm: str
) -> None:
    (setup,), _ = training_setups(
        [(meadow_env.name, meadow_env)], ["mlp"], [algorithm], num_envs=ENVS, num_steps=STEPS
    )
    key = jax.random.key(0)
    worlds = jax.eval_shape(make_train(meadow_env, setup.config).init, key).worlds
    assert jax.eval_shape(idle_rollout(meadow_env, setup.config), worlds, key).reward.shape == (
        STEPS,
        ENVS,
        meadow_env.num_agents,
    )


def test_what_is_measured(meadow_env: Environment) -> None:
    """Every combination, vdn once; its rollouts are those of its configuration."""
    setups, refused = training_setups(
        [(meadow_env.name, meadow_env)], ["mlp", "cnn"], ["ippo", "vdn"], ["shared", "per_agent"]
    )
    assert [(setup.network, *setup.learning) for setup in setups] == [
        (network, *learner)
        for network in ("mlp", "cnn")
        for learner in (("ippo", "shared"), ("ippo", "per_agent"), ("vdn", "shared"))
    ]
    sizes = {setup.learning[0]: (setup.config.num_envs, setup.config.num_steps) for setup in setups}
    assert sizes == {"ippo": (16, 128), "vdn": (32, 1)}
    assert refused == ()
    (odd,), refused = training_setups(
        [(meadow_env.name, meadow_env)], ["mlp"], ["ippo", "vdn"], num_envs=3, num_steps=5
    )
    assert (odd.learning[0], odd.config.steps_per_update) == ("vdn", 15), (
        "its buffer is rounded up to whole updates"
    )
    assert "cannot be split into num_minibatches = 8" in refused[0]


@pytest.mark.slow
def test_a_variant_is_measured_under_its_own_name(meadow_env: Environment) -> None:
    (setup,), _ = training_setups(
        [("meadow+dry", meadow_env)], ["mlp"], num_envs=ENVS, num_steps=STEPS
    )
    (split,) = measure_training([setup], repeats=1).splits
    assert split.name == "meadow+dry"


def test_forms_of_one_name_are_all_measured(meadow_env: Environment) -> None:
    """A game with its own number of agents and with another has one name."""
    setups, _ = training_setups(
        [(meadow_env.name, meadow_env)] * 2, ["mlp"], num_envs=ENVS, num_steps=STEPS
    )
    assert [setup.name for setup in setups] == ["meadow", "meadow"]


def split_of(update: tuple[float, ...], **other: str) -> Split:
    return Split("meadow", 2, "mlp", 4, 8, 1.0, update, (0.1,), (0.2,), (0.3,), 1e6, **other)


def test_hours_are_those_of_the_updates() -> None:
    """32 steps take a second: 1e9 of them 1e9 / 32 / 3600 hours."""
    split = split_of((1.0, 2.0, 0.5), algorithm="mappo", sharing="per_agent")
    hours = 1e9 / 32 / 3600
    assert split.hours_to(10**9) == pytest.approx((hours, hours / 2, hours * 2))
    assert split.env_steps_per_s == 32.0
    measured = Training({"platform": "cpu"}, 1e9, (split_of((1.0,)),), 10**9)
    updates, extrapolated = tables_of(measured)
    assert updates.title == "one update of IPPO: 4 environments, 8 steps"
    assert (
        extrapolated.title
        == "hours of training for 1,000,000,000 environment steps of one seed, extrapolated from these updates"
    )
    assert extrapolated.rows == (
        ("meadow", "2", "mlp", "ippo", "shared", "0.032k", "8,681", "8,681", "8,681"),
    )


def test_figures_without_an_algorithm_are_of_ippo(tmp_path: Path) -> None:
    """Files that were written before there was a choice."""
    row = asdict(split_of((1.0,)))
    del row["algorithm"], row["sharing"]
    machine = {
        "platform": "cpu",
        "device": "a device",
        "cpu_cores": 2,
        "python": "3",
        "jax": "0",
        "compilation_cache": False,
    }
    file = tmp_path / "old.json"
    file.write_text(
        json.dumps({"sort": "training", "machine": machine, "flops_per_s": 1e9, "splits": [row]})
    )
    assert read_figures(file) == Training(machine, 1e9, (split_of((1.0,)),))
    assert (
        "one update of IPPO: 4 environments, 8 steps"
        in CliRunner().invoke(main, ["tables", str(file)]).output
    )


@pytest.mark.slow
def test_the_table_has_the_parts(training: Training) -> None:
    table = training_table(training)
    assert all(len(row) == len(table.headings) for row in table.rows)
    assert [row[:5] for row in table.rows] == [
        ("meadow", "2", "mlp", "ippo", "shared"),
        ("meadow", "2", "mlp", "vdn", "shared"),
    ]
    assert table.title == "one update of IPPO, VDN: 4 environments, 8 steps"


@pytest.mark.slow
def test_on_the_command_line(meadow: Path, tmp_path: Path) -> None:
    figures = tmp_path / "figures.json"
    asked = [
        "--algorithms",
        "mappo",
        "--sharings",
        "per_agent",
        "--hours",
        "1e6",
        "--json",
        str(figures),
    ]
    shown = (
        CliRunner()
        .invoke(
            main, ["training", str(meadow), *asked, "--envs", "2", "--steps", "4", "--repeats", "1"]
        )
        .output
    )
    assert "one update of MAPPO: 2 environments, 4 steps" in shown
    assert "extrapolated" in shown
    stored = json.loads(figures.read_text())
    assert [(row["algorithm"], row["sharing"], row["num_steps"]) for row in stored["splits"]] == [
        ("mappo", "per_agent", 4)
    ]
    assert stored["hours_to"] == 1_000_000


def test_nothing_that_can_be_measured_is_said(meadow: Path) -> None:
    found = CliRunner().invoke(main, ["training", str(meadow), "--envs", "3", "--steps", "5"])
    assert found.exit_code == 1
    assert (
        "meadow, mlp, ippo, shared: num_envs x num_steps = 3 x 5 = 15 steps cannot be split"
        in found.output
    )

"""Where an update of training spends its time: the network's operations are those of its matrices."""

from pathlib import Path

import jax
import pytest
from click.testing import CliRunner

from bench.speed.__main__ import main
from bench.speed.tables import tables_of
from bench.speed.training import (
    Split,
    Training,
    flops_of,
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


def test_nothing_that_can_be_measured_is_said(meadow: Path) -> None:
    found = CliRunner().invoke(main, ["training", str(meadow), "--envs", "3", "--steps", "5"])
    assert found.exit_code == 1
    assert (
        "meadow, mlp, ippo, shared: num_envs x num_steps = 3 x 5 = 15 steps cannot be split"
        in found.output
    )

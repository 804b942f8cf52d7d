"""Where in an episode the environments of a run begin."""

from dataclasses import replace

import jax.numpy as jnp
import numpy as np
import pytest
from probes import Probe, quick

from sjdsl.trainers import make_train
from sjdsl.trainers.runs.compiled import compile_train, with_spread_starts

LENGTH = 4


def first_step_pays() -> Probe:
    """Four steps, the first of which pays 1: what is left of an episode in which all is eaten at once."""
    return Probe(
        "first step pays",
        reward=lambda state, _: 1.0 * (state.step == 0),
        length=lambda _: jnp.int32(LENGTH),
        episode_length=LENGTH,
    )


@pytest.mark.parametrize(
    ("steps", "begun"),
    [
        pytest.param(1, [0, 1, 2, 3], marks=pytest.mark.thorough),
        (3, [0, 0, 3, 3]),
        pytest.param(4, [0] * 4, marks=pytest.mark.thorough),
    ],
)
def test_starts_are_a_rollout_apart_and_returns_are_those_of_whole_episodes(
    steps: int, begun: list[int]
) -> None:
    config = quick(num_envs=4, num_steps=steps, num_minibatches=1)
    program = replace(
        make_train(first_step_pays(), config), learn=lambda state, _: (state, {})
    )  # compiled more quickly
    run = with_spread_starts(compile_train(program, config), config, LENGTH)
    worlds = run.start().worlds
    assert worlds.state.step.tolist() == begun
    assert worlds.sums.length.tolist() == begun
    np.testing.assert_array_equal(worlds.sums.returns[:, 0], np.minimum(begun, 1))

"""Figures of episodes that end, against figures worked out by hand."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from probes import uneven

from sjdsl.trainers.algorithms.episodes import (
    EpisodeSums,
    add_step,
    mean_episode,
    split_finished,
    without_value,
    zero_sums,
)
from sjdsl.trainers.runs.metric_rows import flatten_metrics


def played(
    steps: list[tuple[list[list[float]], list[list[int]], list[int], list[float]]],
) -> EpisodeSums:
    """Returns what three episodes of two agents come to. A step: rewards, what each agent ate, alarms, apples left."""
    sums = zero_sums(uneven(), 3)
    sums = sums.replace(
        events={"eaten": jnp.zeros((3, 2), jnp.int32), "alarms": jnp.zeros(3, jnp.int32)},
        metric_sums={"apples": jnp.zeros(3)},
        metric_finals={"apples": jnp.zeros(3)},
    )
    for reward, eaten, alarms, apples in steps:
        info = {
            "events": {"eaten": jnp.array(eaten), "alarms": jnp.array(alarms)},
            "metrics": {"apples": jnp.array(apples)},
        }
        sums = add_step(sums, jnp.array(reward), 10 * jnp.array(reward), info)
    return sums


STEPS = [
    ([[1.0, 0.0], [2.0, 2.0], [0.0, 0.0]], [[1, 0], [1, 1], [0, 0]], [0, 1, 0], [9.0, 8.0, 7.0]),
    ([[2.0, 1.0], [0.0, 2.0], [5.0, -1.0]], [[0, 1], [0, 1], [2, 0]], [1, 1, 0], [6.0, 4.0, 1.0]),
]


def test_two_of_three_episodes_end() -> None:
    """Their returns are (3, 1) and (2, 4): equalities 3/4 and 5/6; the third, with a negative return, runs on."""
    running, finished = split_finished(played(STEPS), jnp.array([True, True, False]))
    mean = mean_episode(finished)
    assert (int(mean["episodes"]), float(mean["episode_length"])) == (2, 2.0)
    assert mean["agent_return"].tolist() == [2.5, 2.5]
    assert mean["shaped_agent_return"].tolist() == [25, 25]
    assert float(mean["collective_return"]) == 5
    assert float(mean["equality"]) == pytest.approx((3 / 4 + 5 / 6) / 2)
    assert mean["event"]["eaten"].tolist() == [1, 1.5]
    assert float(mean["event"]["alarms"]) == 1.5
    assert float(mean["mean"]["apples"]) == (7.5 + 6) / 2
    assert float(mean["final"]["apples"]) == 5
    assert running.returns.tolist() == [[0, 0], [0, 0], [5, -1]]
    assert running.length.tolist() == [0, 0, 2]
    assert running.events["eaten"].tolist() == [[0, 0], [0, 0], [2, 0]]
    assert running.metric_sums["apples"].tolist() == [0, 0, 8]


def test_equality_is_told_only_if_every_episode_has_it() -> None:
    _, finished = split_finished(played(STEPS), jnp.array([True, True, True]))
    mean = mean_episode(finished)
    assert without_value(mean) == {"equality"}
    assert float(mean["collective_return"]) == pytest.approx((4 + 6 + 4) / 3)
    row = flatten_metrics(mean)
    assert np.isnan(row["equality"])
    assert row["event_eaten_agent_0"] == pytest.approx(4 / 3)
    assert "equalities" not in row


def test_no_episode_ends() -> None:
    running, finished = split_finished(played(STEPS), jnp.zeros(3, bool))
    mean = mean_episode(finished)
    assert all(np.isfinite(leaf).all() for leaf in jax.tree.leaves(mean)), "a program gives no NaN"
    row = flatten_metrics(mean)
    assert row.pop("episodes") == 0
    assert np.isnan([*row.values()]).all()
    assert {
        "collective_return",
        "equality",
        "mean_apples",
        "final_apples",
        "event_eaten_agent_1",
        "return",
        "shaped_return_agent_0",
    } < {*row}
    assert running.length.tolist() == [2, 2, 2]

"""Evaluation: episodes are counted to their end and no further, and intervals are right."""

import json
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from probes import matching, uneven

from sjdsl.trainers import Evaluation, estimate, evaluate, random_policy, save_evaluation, summarise
from sjdsl.trainers.policies.evaluation import evaluation_key

EPISODES = 64


def test_episodes_of_different_length_are_each_played_to_the_end() -> None:
    evaluation = evaluate(uneven(), lambda _, __: jnp.array([1, 0]), jax.random.key(0), EPISODES)
    assert set(evaluation.lengths) == {2, 5}
    np.testing.assert_array_equal(evaluation.returns[:, 0], evaluation.lengths)
    np.testing.assert_array_equal(evaluation.returns[:, 1], 0)
    np.testing.assert_array_equal(evaluation.collective_returns, evaluation.lengths)
    np.testing.assert_array_equal(evaluation.events["second_action"][:, 0], evaluation.lengths)
    np.testing.assert_array_equal(evaluation.events["second_action"][:, 1], 0)
    np.testing.assert_array_equal(evaluation.events["steps"], evaluation.lengths)
    np.testing.assert_allclose(evaluation.metric_means["step"], (evaluation.lengths + 1) / 2)
    np.testing.assert_array_equal(evaluation.metric_finals["step"], evaluation.lengths)


def test_a_scripted_policy_sees_the_observation() -> None:
    def follow(key: jax.Array, observation: jax.Array) -> jax.Array:
        del key
        return observation[:, 0, 0, 0].astype(jnp.int32)

    evaluation = evaluate(matching(), follow, jax.random.key(0), EPISODES)
    assert (evaluation.returns == 1.0).all()
    summary = summarise(evaluation)
    assert (summary["collective return"].mean, summary["return of agent 1"].mean) == (2.0, 1.0)


def test_the_random_policy_draws_for_each_agent_and_episode() -> None:
    evaluation = evaluate(matching(), random_policy(matching()), jax.random.key(0), 400)
    assert 0.4 < evaluation.returns.mean() < 0.6
    alike = (
        evaluation.events["second_action"][:, 0] == evaluation.events["second_action"][:, 1]
    ).mean()
    assert 0.4 < alike < 0.6
    interval = summarise(evaluation)["collective return"]
    assert interval.low < 1.0 < interval.high


def test_the_same_key_gives_the_same_episodes() -> None:
    first, again, other = (
        evaluate(matching(), random_policy(matching()), jax.random.key(seed), EPISODES).returns
        for seed in (1, 1, 2)
    )
    np.testing.assert_array_equal(first, again)
    assert (first != other).any()


def test_intervals_are_students() -> None:
    """Five samples with mean 3 and standard deviation sqrt(2.5); t(0.975, 4) = 2.776445."""
    interval = estimate(np.arange(1.0, 6.0))
    margin = 2.776445 * np.sqrt(2.5) / np.sqrt(5)
    assert (interval.mean, interval.low, interval.high) == pytest.approx(
        (3.0, 3.0 - margin, 3.0 + margin), rel=1e-6
    )
    assert estimate(np.array([1.0])).high == np.inf


def test_what_is_not_defined_is_null(tmp_path: Path) -> None:
    """In an episode, and in the mean over episodes of which one has it not."""
    returns = np.array([[3.0, 1.0], [5.0, -1.0]])
    save_evaluation(Evaluation(returns, np.ones(2), {}, {}, {}), tmp_path / "evaluation.json")
    stored = json.loads((tmp_path / "evaluation.json").read_text())
    assert stored["per_episode"]["equalities"] == [0.75, None]
    assert stored["summary"]["equality"] == {"mean": None, "low": None, "high": None}
    assert stored["summary"]["collective return"]["mean"] == 4


def test_an_evaluation_can_be_stored(tmp_path: Path) -> None:
    evaluation = evaluate(uneven(), lambda _, __: jnp.array([1, 0]), jax.random.key(0), 3)
    save_evaluation(evaluation, tmp_path / "evaluation.json")
    stored = json.loads((tmp_path / "evaluation.json").read_text())
    assert stored["episodes"] == 3
    assert stored["per_episode"]["returns"] == evaluation.returns.tolist()
    assert stored["per_episode"]["events"]["steps"] == evaluation.lengths.tolist()
    assert stored["per_episode"]["equalities"] == [0.5] * 3
    assert stored["per_episode"]["metric_means"]["step"] == ((evaluation.lengths + 1) / 2).tolist()
    assert stored["summary"]["return of agent 1"] == {"mean": 0.0, "low": 0.0, "high": 0.0}


def test_the_keys_of_evaluations_are_none_of_the_runs() -> None:
    """JAX's fold_in(key, i) is split(key, n)[i]: numbers alone would meet the keys that a run of the seed is made of."""
    words = {
        tuple(map(int, jax.random.key_data(key)))
        for seed in range(3)
        for key in (
            jax.random.key(seed),
            *jax.random.split(jax.random.key(seed), 64),
            *(evaluation_key(seed, n) for n in range(64)),
        )
    }
    assert len(words) == 3 * (1 + 64 + 64)

"""PPO learns the values and the actions that can be worked out by hand."""

from typing import Any

import jax
import numpy as np
import pytest
from probes import (
    cued,
    delayed,
    different,
    dilemma,
    hidden,
    judge,
    learn,
    matching,
    opposite,
    recalled,
    stream,
)

TOLERANCE = 0.1
CENTRAL = {"algorithm": "mappo"}
OF_STATE = {"algorithm": "mappo", "critic": "state"}
POOLED = {"algorithm": "mappo", "critic": "pooled"}
CRITICS = pytest.mark.parametrize(
    "changes",
    [
        {},
        pytest.param(CENTRAL, marks=pytest.mark.slow),
        pytest.param(OF_STATE, marks=pytest.mark.thorough),
    ],
    ids=["own window", "all windows", "state"],
)


def test_value_is_discounted_once_a_step() -> None:
    state, _ = learn(delayed())
    np.testing.assert_allclose(judge(delayed(), state, 0)[1], 0.8, atol=TOLERANCE)
    np.testing.assert_allclose(judge(delayed(), state, 1)[1], 1.0, atol=TOLERANCE)


def test_value_depends_on_the_observation() -> None:
    state, metrics = learn(cued())
    np.testing.assert_allclose(judge(cued(), state, 0)[1], -1.0, atol=TOLERANCE)
    np.testing.assert_allclose(judge(cued(), state, 1)[1], 1.0, atol=TOLERANCE)
    assert metrics["explained_variance"][-1] > 0.95


@pytest.mark.parametrize("precision", ["float32", pytest.param("bfloat16", marks=pytest.mark.slow)])
def test_action_depends_on_the_observation(precision: str) -> None:
    """Whatever the precision of the layers, parameters are float32."""
    state, metrics = learn(matching(), precision=precision)
    for cue in (0, 1):
        probabilities, values = judge(matching(), state, cue, precision=precision)
        assert (probabilities[:, cue] > 0.95).all()
        np.testing.assert_allclose(values, 1.0, atol=TOLERANCE)
    assert metrics["collective_return"][-1] > 1.9
    assert np.isfinite(metrics["loss"]).all()
    assert (metrics["loss"] == learn(matching())[1]["loss"]).all() == (precision == "float32")
    assert {leaf.dtype.name for leaf in jax.tree.leaves(state.learner.params)} == {"float32"}


def _stream_values(ends: str, **changes: Any) -> list[list[float]]:
    """Returns agent 0's values after cue 0 and after cue 1 at steps 0, 1, 2 of the three-step stream, gamma 0.8."""
    state, _ = learn(stream(ends), **changes)

    def value(cue: int, step: int) -> float:
        world = [cue, step] if "critic" in changes else None
        return float(judge(stream(ends), state, cue + 2 * step, world, **changes)[1][0])

    return [[value(cue, step) for step in range(3)] for cue in (0, 1)]


@CRITICS
def test_time_limit_is_no_ending(changes: dict[str, Any]) -> None:
    """An endless reward of 1 is worth 1 / (1 - 0.8), wherever it is cut, and whatever the next episode pays."""
    nothing, stream_of_ones = _stream_values("truncated", **changes)
    np.testing.assert_allclose(nothing, [0.0, 0.0, 0.0], atol=0.2)
    np.testing.assert_allclose(stream_of_ones, [5.0, 5.0, 5.0], atol=0.3)


@CRITICS
def test_true_ending_is_worth_nothing(changes: dict[str, Any]) -> None:
    nothing, three_ones = _stream_values("terminated", **changes)
    np.testing.assert_allclose(nothing, [0.0, 0.0, 0.0], atol=TOLERANCE)
    np.testing.assert_allclose(three_ones, [1 + 0.8 + 0.64, 1 + 0.8, 1.0], atol=TOLERANCE)


@pytest.mark.parametrize(
    ("reward", "action"),
    [("individual", 1), pytest.param("common", 0, marks=pytest.mark.thorough)],
)
def test_reward_decides_the_dilemma(reward: str, action: int) -> None:
    state, metrics = learn(dilemma(), reward=reward)
    probabilities, _ = judge(dilemma(), state, 0)
    assert (probabilities[:, action] > 0.95).all()
    payoff = {"individual": 1.0, "common": 3.0}[reward]
    np.testing.assert_allclose(metrics["agent_return"][-1], [payoff, payoff], atol=0.3)


@pytest.mark.thorough
def test_agents_with_networks_of_their_own_learn_opposite_things() -> None:
    """Nothing they see tells them apart: with one network both do the same at best, or draw, and one of two is paid."""
    state, metrics = learn(opposite(), sharing="per_agent")
    probabilities, _ = judge(opposite(), state, 0, sharing="per_agent")
    assert probabilities[0, 0] > 0.95
    assert probabilities[1, 1] > 0.95
    assert metrics["collective_return"][-1] > 1.9
    _, together = learn(opposite())
    np.testing.assert_allclose(together["collective_return"][-10:], 1.0, atol=0.2)


@pytest.mark.thorough
def test_a_central_critic_sees_what_an_agent_does_not() -> None:
    """A critic of agent 0's own window knows only the mean."""
    own, everybodys, pooled, of_state = (
        learn(hidden(), **changes)[0] for changes in ({}, CENTRAL, POOLED, OF_STATE)
    )
    for cue, worth in ((0, -1.0), (1, 1.0)):
        np.testing.assert_allclose(judge(hidden(), own, [2, cue])[1], [0.0, worth], atol=0.2)
        for state, changes in ((everybodys, CENTRAL), (pooled, POOLED)):
            np.testing.assert_allclose(
                judge(hidden(), state, [2, cue], **changes)[1], [worth, worth], atol=TOLERANCE
            )
        np.testing.assert_allclose(
            judge(hidden(), of_state, [2, cue], [cue, 0], **OF_STATE)[1],
            [worth, worth],
            atol=TOLERANCE,
        )


@CRITICS
def test_a_central_critic_tells_agents_apart(changes: dict[str, Any]) -> None:
    """Both see the same, and are paid 1 and -1: a critic of one window, which both share, can only say the mean."""
    state, _ = learn(different(), **changes)
    world = [0.5, 0.0] if "critic" in changes else None
    worth = [1.0, -1.0] if changes else [0.0, 0.0]
    np.testing.assert_allclose(judge(different(), state, 0, world, **changes)[1], worth, atol=0.2)


@pytest.mark.thorough
@pytest.mark.parametrize(
    "changes",
    [
        {},
        pytest.param(CENTRAL, marks=pytest.mark.slow),
        pytest.param({"sharing": "per_agent"}, marks=pytest.mark.slow),
    ],
    ids=["ippo", "mappo", "per agent"],
)
def test_memory_recalls_a_cue(changes: dict[str, Any]) -> None:
    _, metrics = learn(recalled(), memory="gru", **changes)
    assert metrics["collective_return"][-1] > 2 * 0.95


@pytest.mark.thorough
def test_without_memory_a_cue_is_forgotten() -> None:
    """Half of the guesses are right, two a episode: over 10 rollouts of 128 episodes the mean's standard error is 0.02."""
    _, metrics = learn(recalled())
    assert float(metrics["collective_return"][-10:].mean()) == pytest.approx(1.0, abs=0.1)

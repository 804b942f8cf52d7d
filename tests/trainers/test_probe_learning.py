"""PPO learns the values and the actions that can be worked out by hand."""

import numpy as np
import pytest
from probes import constant, cued, delayed, dilemma, judge, learn, matching, stream

TOLERANCE = 0.1


def test_value_of_a_constant_reward() -> None:
    state, _ = learn(constant(0.7))
    assert judge(constant(0.7), state, 0)[1] == pytest.approx(0.7, abs=TOLERANCE)


def test_value_is_discounted_once_a_step() -> None:
    state, _ = learn(delayed(), gamma=0.5)
    assert judge(delayed(), state, 0)[1] == pytest.approx(0.5, abs=TOLERANCE)
    assert judge(delayed(), state, 1)[1] == pytest.approx(1.0, abs=TOLERANCE)


def test_value_depends_on_the_observation() -> None:
    state, metrics = learn(cued())
    assert judge(cued(), state, 0)[1] == pytest.approx(-1.0, abs=TOLERANCE)
    assert judge(cued(), state, 1)[1] == pytest.approx(1.0, abs=TOLERANCE)
    assert metrics["explained_variance"][-1] > 0.95


def test_action_depends_on_the_observation() -> None:
    state, metrics = learn(matching())
    for cue in (0, 1):
        probabilities, value = judge(matching(), state, cue)
        assert probabilities[cue] > 0.95
        assert value == pytest.approx(1.0, abs=TOLERANCE)
    assert metrics["collective_return"][-1] > 1.9


def _stream_values(ends: str) -> list[list[float]]:
    """Returns the values after cue 0 and after cue 1 at steps 0, 1, 2 of the three-step stream, gamma 0.8."""
    state, _ = learn(stream(ends), gamma=0.8, clip_value_loss=False, total_timesteps=60_000)
    return [[judge(stream(ends), state, cue + 2 * step)[1] for step in range(3)] for cue in (0, 1)]


def test_time_limit_is_no_ending() -> None:
    """An endless reward of 1 is worth 1 / (1 - 0.8), wherever it is cut, and whatever the next episode pays."""
    nothing, stream_of_ones = _stream_values("truncated")
    np.testing.assert_allclose(nothing, [0.0, 0.0, 0.0], atol=0.2)
    np.testing.assert_allclose(stream_of_ones, [5.0, 5.0, 5.0], atol=0.3)


def test_true_ending_is_worth_nothing() -> None:
    nothing, three_ones = _stream_values("terminated")
    np.testing.assert_allclose(nothing, [0.0, 0.0, 0.0], atol=TOLERANCE)
    np.testing.assert_allclose(three_ones, [1 + 0.8 + 0.64, 1 + 0.8, 1.0], atol=TOLERANCE)


@pytest.mark.parametrize(("reward", "action"), [("individual", 1), ("common", 0)])
def test_reward_decides_the_dilemma(reward: str, action: int) -> None:
    state, metrics = learn(dilemma(), reward=reward)
    probabilities, _ = judge(dilemma(), state, 0)
    assert probabilities[action] > 0.95
    payoff = {"individual": 1.0, "common": 3.0}[reward]
    np.testing.assert_allclose(metrics["agent_return"][-1], [payoff, payoff], atol=0.3)

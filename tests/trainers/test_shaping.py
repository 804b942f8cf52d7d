"""Shaped rewards against their closed forms."""

import jax.numpy as jnp
import numpy as np
import pytest

from sjdsl.trainers.shaping import shape_reward

REWARD = jnp.array([[[1.0, -2.0, 4.0]], [[0.0, 0.5, 0.0]]])  # [T=2, B=1, N=3]


def test_individual_is_the_raw_reward() -> None:
    np.testing.assert_array_equal(shape_reward(REWARD, "individual"), REWARD)


def test_common_is_the_sum_for_everyone() -> None:
    np.testing.assert_array_equal(shape_reward(REWARD, "common"), [[[3.0, 3.0, 3.0]], [[0.5, 0.5, 0.5]]])


@pytest.mark.parametrize("mode", ["individual", "common"])
def test_mean_return_of_symmetric_agents_scales_by_their_number_at_most(mode: str) -> None:
    """Common reward multiplies the group's reward by N; individual reward leaves it."""
    factor = {"individual": 1.0, "common": 3.0}[mode]
    np.testing.assert_allclose(shape_reward(REWARD, mode).sum(-1), factor * REWARD.sum(-1))


def test_one_agent_alone_is_its_own_group() -> None:
    np.testing.assert_array_equal(shape_reward(REWARD[..., :1], "common"), shape_reward(REWARD[..., :1], "individual"))

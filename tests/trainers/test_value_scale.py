"""Value normalisation: the critic's units follow the targets, and values stay what they were."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from probes import FAST_TO_COMPILE, delayed, judge, learn, matching, quick

from sjdsl.trainers import PPOConfig
from sjdsl.trainers.networks.actor_critics import make_actor_critics
from sjdsl.trainers.networks.value_scale import (
    LEAST_VARIANCE,
    RATE,
    converted,
    follow_targets,
    value_unit,
)

NORMALISED = {"normalise_values": True}


def first_network(**changes: Any) -> tuple[Any, Any]:
    """Returns networks, and the parameters of the first."""
    config = quick(**changes)
    assert isinstance(config, PPOConfig)
    networks = make_actor_critics(matching(), config)
    start = jax.jit(lambda key: networks.init(key, matching()), compiler_options=FAST_TO_COMPILE)
    parameters = start(jax.random.key(0))
    return networks, jax.tree.map(lambda leaf: leaf[0], parameters)


def values_of(networks: Any, parameters: Any) -> np.ndarray:
    windows = jnp.arange(6, dtype=jnp.uint8).reshape(1, 3, 2, 1, 1, 1) % 3
    fresh = jnp.ones((1, 3), bool)
    read = jax.jit(
        lambda parameters: networks.network.apply(
            parameters, (), windows, None, fresh, jnp.arange(2)
        )[2]
    )
    return np.asarray(read(parameters))


@pytest.mark.parametrize("first", [True, False])
def test_moments_follow_and_values_stay(first: bool) -> None:
    networks, parameters = first_network(**NORMALISED)
    target = np.random.default_rng(0).normal(50.0, 20.0, (1, 40, 2)).astype(np.float32)
    moved = jax.jit(follow_targets)(parameters, jnp.asarray(target), jnp.bool_(first))
    rate = 1.0 if first else RATE
    mean = rate * target.mean()
    square = (1 - rate) * 1.0 + rate * np.square(target).mean()
    critic = moved["params"]["critic"]
    np.testing.assert_allclose(critic["mean"], mean, rtol=1e-5)
    np.testing.assert_allclose(value_unit(moved), np.sqrt(square - mean**2), rtol=1e-4)
    np.testing.assert_allclose(
        values_of(networks, moved), values_of(networks, parameters), atol=1e-4
    )


def test_equal_targets_are_not_scaled_up() -> None:
    _, parameters = first_network(**NORMALISED)
    moved = jax.jit(follow_targets)(parameters, jnp.full((1, 4, 2), 3.0), jnp.bool_(True))
    np.testing.assert_allclose(value_unit(moved), np.sqrt(LEAST_VARIANCE), rtol=1e-5)


@pytest.mark.thorough
def test_values_are_learnt_in_the_games_scale() -> None:
    """0.8 of a reward of 1 in the next step, and the reward itself; the moments take no gradient."""
    state, _ = learn(delayed(), **NORMALISED)
    for shown, worth in ((0, 0.8), (1, 1.0)):
        np.testing.assert_allclose(judge(delayed(), state, shown, **NORMALISED)[1], worth, atol=0.1)
    moments = [
        leaf
        for path, leaf in jax.tree_util.tree_leaves_with_path(state.learner.opt_state)
        if "deviation" in jax.tree_util.keystr(path)
    ]
    assert moments
    assert all(not np.asarray(leaf).any() for leaf in moments)


@pytest.mark.parametrize("sharing", ["shared", "per_agent"])
def test_parameters_are_converted_both_ways(sharing: str) -> None:
    plain, parameters = first_network(sharing=sharing)
    scaled, _ = first_network(**NORMALISED, sharing=sharing)
    with_moments = converted(parameters, normalised=True)
    moved = jax.jit(follow_targets)(with_moments, jnp.array([10.0, 30.0]), jnp.bool_(True))
    wanted = values_of(plain, parameters)
    np.testing.assert_allclose(values_of(scaled, moved), wanted, atol=1e-5)
    np.testing.assert_allclose(
        values_of(plain, converted(moved, normalised=False)), wanted, atol=1e-5
    )
    assert converted(parameters, normalised=False) is parameters

"""The network: shapes, initial scale, and that it sees every plane."""

import flax.linen as nn
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from sjdsl.runtime.planes import TokenPlane
from sjdsl.trainers.convolution import convolve
from sjdsl.trainers.networks import ActorCritic

PLANES = (
    TokenPlane("content", "word", ("outside", "none", "mine")),
    TokenPlane("marks", "bits", ("zapped", "cleaned")),
    TokenPlane("bag", "number", high=200),
)


@pytest.fixture(scope="module", params=["mlp", "cnn"])
def network(request: pytest.FixtureRequest) -> ActorCritic:
    return ActorCritic(7, PLANES, request.param, 64)


def _observations(key: jax.Array) -> jax.Array:
    return jax.random.randint(key, (5, 2, 3, 11, 11), 0, 3).astype(jnp.uint8)


def test_shapes_and_initial_scale(network: ActorCritic) -> None:
    observation_key, network_key = jax.random.split(jax.random.key(0))
    observation = _observations(observation_key)
    parameters = jax.jit(network.init)(network_key, observation)
    logits, value = network.apply(parameters, observation)
    assert logits.shape == (5, 2, 7)
    assert value.shape == (5, 2)
    assert jax.nn.softmax(logits).max() < 1 / 7 + 0.02
    actor, critic = (parameters["params"][head]["kernel"] for head in ("actor", "critic"))
    np.testing.assert_allclose(actor.T @ actor, 0.01**2 * np.eye(7), atol=1e-6)
    np.testing.assert_allclose(critic.T @ critic, [[1.0]], atol=1e-5)


def test_every_plane_reaches_the_outputs(network: ActorCritic) -> None:
    observation_key, network_key = jax.random.split(jax.random.key(0))
    observation = _observations(observation_key)
    parameters = jax.jit(network.init)(network_key, observation)
    _, value = network.apply(parameters, observation)
    for plane in range(3):
        _, changed = network.apply(parameters, observation.at[..., plane, 4, 6].set(0))
        assert not np.allclose(value, changed)


def test_convolution_and_its_gradients() -> None:
    """Against flax's convolution, values and both gradients."""
    side = 5
    keys = jax.random.split(jax.random.key(0), 3)
    features = jax.random.normal(keys[0], (4, 11, 11, 6))
    kernel = jax.random.normal(keys[1], (side, side, 6, 8))
    weight = jax.random.normal(keys[2], (4, 11, 11, 8))
    reference = nn.Conv(8, (side, side), use_bias=False)

    def ours(features: jax.Array, kernel: jax.Array) -> jax.Array:
        return (weight * convolve(features, kernel)).sum()

    def theirs(features: jax.Array, kernel: jax.Array) -> jax.Array:
        return (weight * reference.apply({"params": {"kernel": kernel}}, features)).sum()

    values = [jax.jit(jax.value_and_grad(loss, argnums=(0, 1)))(features, kernel) for loss in (ours, theirs)]
    jax.tree.map(lambda a, b: np.testing.assert_allclose(a, b, rtol=1e-3, atol=1e-3), *values)

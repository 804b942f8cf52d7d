"""The networks: shapes, initial weights, that they see every plane, and what memory is."""

from collections.abc import Callable
from functools import cache, partial
from typing import Any

import flax.linen as nn
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from probes import FAST_TO_COMPILE

from sjdsl.runtime.planes import TokenPlane
from sjdsl.trainers import PPOConfig
from sjdsl.trainers.networks.architectures import ActionValues, ActorCritic
from sjdsl.trainers.networks.convolution import convolve
from sjdsl.trainers.networks.initialisation import orthogonal, orthonormal_columns

PLANES = (
    TokenPlane("content", "word", ("outside", "none", "mine")),
    TokenPlane("marks", "bits", ("zapped", "cleaned")),
    TokenPlane("bag", "number", high=200),
)
ENVS, AGENTS, SIDE = 5, 2, 5
FRESH = jnp.zeros((1, ENVS), bool)


def layers(network: str, width: int, **settings: Any) -> PPOConfig:
    return PPOConfig(network=network, network_width=width, **settings)


def _observations(key: jax.Array) -> jax.Array:
    return jax.random.randint(key, (1, ENVS, AGENTS, 3, SIDE, SIDE), 0, 2).astype(jnp.uint8)


def _changed_in_turn(observation: jax.Array) -> jax.Array:
    """Returns `[1 + N * P, ...]`: the observation, and it with one cell of one plane of one agent changed."""
    at = [(agent, plane) for agent in range(AGENTS) for plane in range(3)]
    return jnp.concatenate(
        [observation, *(observation.at[:, :, agent, plane, 2, 3].add(1) for agent, plane in at)]
    )


@pytest.fixture(scope="module", params=["mlp", "cnn"])
def kind(request: pytest.FixtureRequest) -> str:
    return request.param


@cache
def _read_changed(kind: str, critic: str) -> tuple[Any, jax.Array, jax.Array]:
    """Returns parameters, and logits and values `[1 + N * P, B, N, ...]` of `_changed_in_turn`."""
    central = critic == "observations"
    joint_planes = PLANES * AGENTS if central else None
    settings = {} if critic == "window" else {"algorithm": "mappo", "critic": critic}
    network = ActorCritic(7, AGENTS, PLANES, joint_planes, layers(kind, 16, **settings))

    @partial(jax.jit, compiler_options=FAST_TO_COMPILE)
    def read(key: jax.Array) -> tuple[Any, jax.Array, jax.Array]:
        observation_key, network_key = jax.random.split(key)
        seen = _changed_in_turn(_observations(observation_key))
        joint = seen.reshape(-1, ENVS, AGENTS * 3, SIDE, SIDE) if central else None
        fresh = jnp.zeros(seen.shape[:2], bool)
        parameters = network.init(network_key, (), seen, joint, fresh)
        return parameters, *network.apply(parameters, (), seen, joint, fresh)[1:]

    return read(jax.random.key(0))


def test_shapes_and_initial_scale(kind: str) -> None:
    parameters, logits, values = _read_changed(kind, "window")
    assert logits.shape == (1 + AGENTS * 3, ENVS, AGENTS, 7)
    assert values.shape == (1 + AGENTS * 3, ENVS, AGENTS)
    assert jax.nn.softmax(logits).max() < 1 / 7 + 0.02
    actor, critic = (
        np.asarray(parameters["params"][head]["out"]["kernel"]) for head in ("actor", "critic")
    )
    np.testing.assert_allclose(actor.T @ actor, 0.01**2 * np.eye(7), atol=1e-6)
    np.testing.assert_allclose(critic.T @ critic, [[1.0]], atol=1e-5)


def test_actor_and_critic_can_have_their_hidden_layer_in_common() -> None:
    network = ActorCritic(7, AGENTS, PLANES, None, layers("mlp", 16, share_hidden=True))
    observation_key, network_key = jax.random.split(jax.random.key(0))
    observation = _observations(observation_key)
    parameters = network.init(network_key, (), observation, None, FRESH)["params"]
    assert {name: set(parameters[name]) for name in ("actor", "critic")} == {
        "actor": {"out"},
        "critic": {"out"},
    }
    without = parameters | {"Dense_0": jax.tree.map(jnp.zeros_like, parameters["Dense_0"])}
    for changed, is_known in ((parameters, True), (without, False)):
        _, logits, values = network.apply({"params": changed}, (), observation, None, FRESH)
        assert bool(jnp.any(logits != 0)) == is_known
        assert bool(jnp.any(values != 0)) == is_known


def test_every_plane_of_an_agents_own_window_reaches_its_outputs_and_no_other(kind: str) -> None:
    for outputs in map(np.asarray, _read_changed(kind, "window")[1:]):
        told = np.abs(outputs[1:] - outputs[0]).reshape(AGENTS, 3, ENVS, AGENTS, -1).max(axis=-1)
        for changed in range(AGENTS):
            for agent in range(AGENTS):
                assert (told[changed, ..., agent] > 1e-6).all() == (changed == agent)
                assert (told[changed, ..., agent] < 1e-6).all() == (changed != agent)


@pytest.mark.parametrize("kind", ["mlp", pytest.param("cnn", marks=pytest.mark.thorough)])
@pytest.mark.parametrize("critic", ["observations", "pooled"])
def test_every_plane_of_all_windows_reaches_a_central_critic(kind: str, critic: str) -> None:
    """And nothing but an agent's own window reaches its logits."""
    _, logits, values = map(np.asarray, _read_changed(kind, critic))
    assert (np.abs(values[1:] - values[0]) > 1e-6).all()
    told = np.abs(logits[1:] - logits[0]).reshape(AGENTS, 3, ENVS, AGENTS, -1).max(axis=(1, 2, 4))
    assert (told > 1e-6).tolist() == np.eye(AGENTS, dtype=bool).tolist()


@pytest.mark.parametrize("kind", ["mlp", pytest.param("cnn", marks=pytest.mark.thorough)])
def test_action_values_see_every_plane(kind: str) -> None:
    network = ActionValues(7, PLANES, layers(kind, 16))

    @partial(jax.jit, compiler_options=FAST_TO_COMPILE)
    def read(key: jax.Array) -> jax.Array:
        observation_key, network_key = jax.random.split(key)
        seen = _changed_in_turn(_observations(observation_key))
        return network.apply(network.init(network_key, seen), seen)

    values = np.asarray(read(jax.random.key(0)))
    told = np.abs(values[1:] - values[0]).reshape(AGENTS, 3, ENVS, AGENTS, 7).max(axis=-1)
    assert (told > 1e-6).tolist() == np.broadcast_to(
        np.eye(AGENTS, dtype=bool)[:, None, None], told.shape
    ).tolist()


def test_bfloat16_is_of_the_layers_alone() -> None:
    """Parameters and outputs are float32, near those of float32: bfloat16 has 8 bits, so relative errors of 2^-8 a product."""
    exact, coarse = (
        ActorCritic(7, AGENTS, PLANES, None, layers("mlp", 64, precision=name))
        for name in ("float32", "bfloat16")
    )

    @partial(jax.jit, compiler_options=FAST_TO_COMPILE)
    def read(key: jax.Array) -> tuple[Any, jax.Array, jax.Array]:
        observation_key, network_key = jax.random.split(key)
        seen = _observations(observation_key)
        parameters = coarse.init(network_key, (), seen, None, FRESH)
        return parameters, *(
            network.apply(parameters, (), seen, None, FRESH)[2] for network in (exact, coarse)
        )

    parameters, wanted, found = read(jax.random.key(0))
    assert {leaf.dtype.name for leaf in jax.tree.leaves(parameters)} == {"float32"}
    assert found.dtype == jnp.float32
    assert (wanted != found).any()
    np.testing.assert_allclose(found, wanted, atol=0.05 * float(jnp.abs(wanted).max()))


# memory


LENGTH = 6


@pytest.mark.thorough
@pytest.mark.parametrize("central", [pytest.param(False, marks=pytest.mark.slow), True])
def test_steps_read_one_by_one_or_together_are_the_same_and_memory_ends_with_an_episode(
    central: bool,
) -> None:
    """Two pasts that differ in their first step are told apart until an episode begins, at step 3."""
    joint_planes = PLANES[:1] if central else None
    network = ActorCritic(3, AGENTS, PLANES[:1], joint_planes, layers("mlp", 8, memory="gru"))
    start = network.start_memory(ENVS)
    fresh = jnp.zeros((LENGTH, ENVS), bool).at[3].set(True)

    def windows(tokens: jax.Array) -> tuple[jax.Array, jax.Array | None]:
        seen = tokens[..., None, None, None].astype(jnp.uint8)
        return seen, seen[:, :, 0] if central else None

    @partial(jax.jit, compiler_options=FAST_TO_COMPILE)
    def read(key: jax.Array) -> tuple[Any, ...]:
        network_key, tokens_key = jax.random.split(key)
        tokens = jax.random.randint(tokens_key, (LENGTH, ENVS, AGENTS), 0, 3)
        other = tokens.at[0].set((tokens[0] + 1) % 3)
        parameters = network.init(network_key, start, *windows(tokens), fresh)

        def one_by_one(memory: Any, step: tuple[jax.Array, jax.Array]) -> tuple[Any, Any]:
            memory, logits, values = network.apply(
                parameters, memory, *windows(step[0][None]), step[1][None]
            )
            return memory, (logits[0], values[0])

        together = network.apply(parameters, start, *windows(tokens), fresh)[1:]
        return (
            together,
            jax.lax.scan(one_by_one, start, (tokens, fresh))[1],
            network.apply(parameters, start, *windows(other), fresh)[1:],
        )

    together, stepwise, other = read(jax.random.key(0))
    jax.tree.map(partial(np.testing.assert_allclose, atol=1e-6), together, stepwise)
    for outputs, others in zip(together, other, strict=True):
        assert (np.abs(outputs - others)[1:3].reshape(2, -1).max(axis=1) > 1e-7).all()
        np.testing.assert_array_equal(outputs[3:], others[3:])


# weights and convolutions


def _drawn(gain: float, shape: tuple[int, ...], seed: int = 0) -> jax.Array:
    return jax.jit(lambda key: orthogonal(gain)(key, shape), compiler_options=FAST_TO_COMPILE)(
        jax.random.key(seed)
    )


@pytest.mark.parametrize("shape", [(1331, 64), (64, 1), (7, 64), (5, 5, 3, 32), (64, 64)])
def test_starting_weights_are_orthogonal(shape: tuple[int, ...]) -> None:
    gain = 2.0**0.5
    weights = np.asarray(_drawn(gain, shape), np.float64).reshape(-1, shape[-1]) / gain
    products = weights.T @ weights if weights.shape[0] >= weights.shape[1] else weights @ weights.T
    np.testing.assert_allclose(products, np.eye(len(products)), atol=1e-5)


def test_nearly_parallel_columns_become_orthogonal_too() -> None:
    """Freed of the others once, they would keep errors of rounding a thousand times as large."""
    matrix = 1.0 + 1e-3 * jax.random.normal(jax.random.key(0), (20, 5))
    columns = np.asarray(
        jax.jit(orthonormal_columns, compiler_options=FAST_TO_COMPILE)(matrix), np.float64
    )
    np.testing.assert_allclose(columns.T @ columns, np.eye(5), atol=1e-5)


def _gradients_of(
    convolution: Callable[[jax.Array, jax.Array], jax.Array], weight: jax.Array
) -> Callable[..., Any]:
    """Returns a function to the weighted sum of a convolution and its gradients."""
    return jax.value_and_grad(
        lambda features, kernel: (weight * convolution(features, kernel)).sum(), argnums=(0, 1)
    )


@pytest.mark.parametrize("axes", [(0, 0), (0, None), (None, 0)])
@pytest.mark.parametrize("side", [1, 3])
def test_convolutions_of_several_networks(side: int, axes: tuple[int | None, int | None]) -> None:
    """Values and gradients under `vmap` are those of flax's."""
    reference = nn.Conv(4, (side, side), use_bias=False)

    @partial(jax.jit, compiler_options=FAST_TO_COMPILE)
    def both(key: jax.Array) -> tuple[Any, Any]:
        keys = jax.random.split(key, 3)
        shapes = (2, 5, 5, 2), (side, side, 2, 4)
        stacked = (
            (3, *shape) if axis == 0 else shape for shape, axis in zip(shapes, axes, strict=True)
        )
        features, kernel = (
            jax.random.normal(key, shape) for key, shape in zip(keys[:2], stacked, strict=True)
        )
        weight = jax.random.normal(keys[2], (2, 5, 5, 4))
        theirs = _gradients_of(
            lambda features, kernel: reference.apply({"params": {"kernel": kernel}}, features),
            weight,
        )
        return tuple(
            jax.vmap(each, axes)(features, kernel)
            for each in (_gradients_of(convolve, weight), theirs)
        )

    jax.tree.map(
        partial(np.testing.assert_allclose, rtol=1e-4, atol=1e-4), *both(jax.random.key(0))
    )

"""The first layer of windows is `nn.Dense` on their channels, made in pieces or whole."""

import flax.linen as nn
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jax import Array

from sjdsl.runtime.planes import TokenPlane
from sjdsl.runtime.tokens import to_channels
from sjdsl.trainers import window_layer
from sjdsl.trainers.window_layer import WindowLayer

PLANES = (
    TokenPlane("content", "word", ("floor", "wall", "apple"), 2),
    TokenPlane("marks", "bits", ("fire", "beam"), 3),
    TokenPlane("stock", "number", (), 5),
)
INPUTS = (3 + 2 + 1) * 4 * 4
WIDTH = 5


class Plain(nn.Module):
    """The layer as flax has it."""

    dtype: jnp.dtype

    @nn.compact
    def __call__(self, tokens: Array) -> Array:
        channels = to_channels(tokens, PLANES, self.dtype, scale_numbers=True).reshape(*tokens.shape[:-3], -1)
        return nn.Dense(WIDTH, dtype=self.dtype)(channels)


class Ours(nn.Module):
    """The layer under the same name."""

    dtype: jnp.dtype

    @nn.compact
    def __call__(self, tokens: Array) -> Array:
        return WindowLayer(WIDTH, PLANES, 2.0, self.dtype, name="Dense_0")(tokens)


def draw_windows(seed: int, *lead: int) -> Array:
    high = np.array([2, 3, 5])[:, None, None] + 1
    return jnp.asarray(np.random.default_rng(seed).integers(0, high, (*lead, 3, 4, 4)), jnp.uint8)


@pytest.fixture(params=[1, 3, 4, 10_000], ids=lambda rows: f"pieces of {rows}")
def _rows(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """How many windows are in a piece, of float32; 12 are 12, 4, or 3 pieces, or one whole."""
    monkeypatch.setattr(window_layer, "PIECE", request.param * INPUTS * 4)
    monkeypatch.setattr(window_layer, "FEWEST_PIECES", 1)
    monkeypatch.setattr(window_layer, "FEWEST_WINDOWS", 1)
    jax.clear_caches()  # the size is read when a function is traced


@pytest.mark.usefixtures("_rows")
@pytest.mark.parametrize("lead", [(12,), (2, 1, 7), (1,)])
@pytest.mark.parametrize(("dtype", "tolerance"), [(jnp.float32, 1e-5), (jnp.bfloat16, 5e-2)])
def test_the_layer_is_a_dense_one(lead: tuple[int, ...], dtype: jnp.dtype, tolerance: float) -> None:
    """Values and both gradients, whether the last piece is whole or not."""
    tokens = draw_windows(0, *lead)
    parameters = Plain(dtype).init(jax.random.key(1), tokens)
    weights = jnp.asarray(np.random.default_rng(2).normal(size=(*lead, WIDTH)), jnp.float32)

    def of(layer: nn.Module) -> tuple[Array, Array]:
        def loss(parameters: dict) -> tuple[Array, Array]:
            result = layer.apply(parameters, tokens)
            return (weights * jnp.tanh(result.astype(jnp.float32))).sum(), result

        (_, result), gradient = jax.jit(jax.value_and_grad(loss, has_aux=True))(parameters)
        return result, gradient

    jax.tree.map(
        lambda ours, plain: np.testing.assert_allclose(
            np.asarray(ours, np.float32), np.asarray(plain, np.float32), rtol=tolerance, atol=tolerance
        ),
        of(Ours(dtype)),
        of(Plain(dtype)),
    )


@pytest.mark.usefixtures("_rows")
def test_many_networks_at_once() -> None:
    """Under `vmap`, as teams of agents with their own parameters are: over windows, kernels, or both."""
    tokens = jnp.stack([draw_windows(seed, 6) for seed in range(3)])
    parameters = jax.vmap(lambda key: Plain(jnp.dtype(jnp.float32)).init(key, tokens[0]))(jax.random.split(jax.random.key(1), 3))

    def gradient(layer: nn.Module, axes: tuple[int | None, int | None]) -> Array:
        one, windows = (
            jax.tree.map(lambda leaf: leaf[0], each) if axis is None else each for each, axis in zip((parameters, tokens), axes)
        )
        loss = jax.grad(lambda own, seen: jnp.square(layer.apply(own, seen)).sum())
        return jax.jit(jax.vmap(loss, axes))(one, windows)

    for axes in ((0, 0), (0, None), (None, 0)):
        ours, plain = (gradient(layer(jnp.dtype(jnp.float32)), axes) for layer in (Ours, Plain))
        jax.tree.map(lambda a, b: np.testing.assert_allclose(a, b, rtol=1e-4, atol=1e-4), ours, plain)


def test_the_parameters_are_those_of_a_dense_layer() -> None:
    """Names and shapes: policies that were stored before are read."""
    tokens = draw_windows(0, 2)
    ours, plain = (jax.eval_shape(layer(jnp.dtype(jnp.float32)).init, jax.random.key(0), tokens) for layer in (Ours, Plain))
    assert ours == plain

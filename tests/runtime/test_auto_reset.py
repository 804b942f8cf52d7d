"""Derivatives by a parameter of what an episode pays, through the resets: forwards, backwards, in batches, against differences."""

from collections.abc import Callable
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from sjdsl import make
from sjdsl.runtime.env import Environment

STEPS = 9  # of episodes of six steps: each trajectory runs through a reset


@pytest.fixture(scope="module")
def paid() -> Callable[..., jax.Array]:
    """Returns the function of a price and a seed to what the agents are paid, which is proportional to the price."""
    env: Environment = make(Path(__file__).parent / "yard.sj")

    def sum_of_rewards(apple: jax.Array, seed: int | jax.Array) -> jax.Array:
        params = env.params.replace(apple=apple)
        start, *keys = jax.random.split(
            jax.random.PRNGKey(seed), STEPS + 1
        )  # old style: what scans keep for the way back counts as use of a typed one
        _, state = env.reset(start, params)

        def step(state: jax.Array, key: jax.Array) -> tuple[jax.Array, tuple[jax.Array, jax.Array]]:
            act, play = jax.random.split(key)
            _, state, reward, done, _ = env.step(
                play, state, jax.random.randint(act, (3,), 0, 4), params
            )
            return state, (reward.sum(), done)

        _, (rewards, done) = jax.lax.scan(step, state, jnp.stack(keys))
        return jnp.where(done.any(), rewards.sum(), jnp.nan)

    return sum_of_rewards


@pytest.mark.parametrize(
    "derivative", [jax.grad, jax.jacfwd, pytest.param(jax.jacrev, marks=pytest.mark.thorough)]
)
def test_of_one_environment(
    paid: Callable[..., jax.Array], derivative: Callable[..., Callable[..., jax.Array]]
) -> None:
    price, seed = jnp.float32(1.5), jnp.int32(4)
    found = jax.jit(derivative(paid))(price, seed)
    pay = jax.jit(paid)
    assert float(found) == pytest.approx(float(pay(jnp.float32(2.5), seed) - pay(price, seed)))
    assert found > 0


@pytest.mark.thorough
def test_of_batches(paid: Callable[..., jax.Array]) -> None:
    """A batch inside the derivative, and a derivative inside the batch; another batch around that."""
    price, seeds = jnp.float32(1.5), jnp.arange(4)
    each = np.asarray([jax.grad(paid)(price, seed) for seed in seeds])
    assert len(set(each.tolist())) > 1
    inside = jax.grad(lambda price: jax.vmap(paid, (None, 0))(price, seeds).sum())(price)
    np.testing.assert_allclose(inside, each.sum(), rtol=1e-6)
    around = jax.vmap(jax.vmap(jax.grad(paid), (None, 0)), (0, None))(
        jnp.stack([price, price]), seeds
    )
    np.testing.assert_allclose(around, np.stack([each, each]), rtol=1e-6)

"""Advantages against a plain loop over one environment and one agent at a time."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jax import Array

from sjdsl.trainers import PPOConfig
from sjdsl.trainers.algorithms.advantage import generalised_advantages, successor_values
from sjdsl.trainers.algorithms.losses import Batch
from sjdsl.trainers.algorithms.ppo import ppo_loss

STEPS, ENVS, AGENTS = 23, 5, 3


def drawn(seed: int, share_done: float) -> tuple[np.ndarray, ...]:
    """Returns rewards, values, terminal values, last values, and which steps end episodes, for which reason."""
    draw = np.random.default_rng(seed)
    shape = (STEPS, ENVS, AGENTS)
    rewards, values, terminal_values = (
        draw.normal(size=shape).astype(np.float32) for _ in range(3)
    )
    last_value = draw.normal(size=(ENVS, AGENTS)).astype(np.float32)
    done = draw.random((STEPS, ENVS)) < share_done
    truncated = done & (draw.random((STEPS, ENVS)) < 0.5)
    return rewards, values, terminal_values, last_value, done, truncated


def found(drawn: tuple[np.ndarray, ...], gamma: float, gae_lambda: float) -> np.ndarray:
    """Returns what the trainer computes."""
    rewards, values, terminal_values, last_value, done, truncated = map(jnp.asarray, drawn)
    successors = successor_values(values, last_value, terminal_values, done, truncated)
    return np.asarray(generalised_advantages(rewards, values, successors, done, gamma, gae_lambda))


@pytest.mark.parametrize(("seed", "share_done"), [(0, 0.3), (1, 0.0), (2, 1.0), (3, 0.1)])
@pytest.mark.parametrize(("gamma", "gae_lambda"), [(0.97, 0.9), (1.0, 1.0), (0.9, 0.0), (0.0, 0.5)])
def test_advantages_equal_a_plain_loop(
    seed: int, share_done: float, gamma: float, gae_lambda: float
) -> None:
    given = drawn(seed, share_done)
    rewards, values, terminal_values, last_value, done, truncated = given
    expected = np.zeros(values.shape, np.float64)
    for env in range(ENVS):
        for agent in range(AGENTS):
            advantage = 0.0
            following = last_value[env, agent]
            for step in reversed(range(STEPS)):
                if truncated[step, env]:
                    advantage, following = 0.0, terminal_values[step, env, agent]
                elif done[step, env]:
                    advantage, following = 0.0, 0.0
                delta = rewards[step, env, agent] + gamma * following - values[step, env, agent]
                advantage = delta + gamma * gae_lambda * advantage
                expected[step, env, agent] = advantage
                following = values[step, env, agent]
    np.testing.assert_allclose(found(given, gamma, gae_lambda), expected, atol=1e-4)


@pytest.mark.parametrize("deviation", [0.001, 0.02, 5.0])
def test_advantages_are_divided_by_their_deviation_but_not_by_less_than_the_floor(
    deviation: float,
) -> None:
    """With ratios of 1 the gradient by the log probabilities is the advantage that was used: two samples, `deviation` up and down."""
    floor = 0.03
    shape = (1, 2, 1)
    batch = Batch(
        observation=jnp.zeros((*shape, 1, 1), jnp.uint8),
        joint=None,
        fresh=jnp.zeros((1, 2), bool),
        memory=(),
        action=jnp.zeros(shape, jnp.int32),
        log_probability=jnp.full(shape, jnp.log(0.5)),
        value=jnp.zeros(shape),
        advantage=jnp.array([[[4.0 + deviation], [4.0 - deviation]]]),
        target=jnp.zeros(shape),
    )

    def policy_loss(log_ratios: Array) -> Array:
        logits = jnp.stack(
            [log_ratios, jnp.zeros_like(log_ratios)], axis=-1
        )  # both probabilities are 1/2 where it is 0
        config = PPOConfig(advantage_floor=floor)
        return ppo_loss(None, lambda *_: ((), logits, jnp.zeros(shape)), batch, config)[1][
            "policy_loss"
        ]

    used = deviation / max(deviation, floor)
    gradient = jax.grad(policy_loss)(
        jnp.zeros(shape)
    )  # half of a logit's change is its log probability's
    np.testing.assert_allclose(gradient.ravel(), [-used / 4, used / 4], rtol=1e-4)

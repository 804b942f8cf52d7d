"""Advantages against a plain loop over one environment and one agent at a time."""

import jax.numpy as jnp
import numpy as np

from sjdsl.trainers.advantage import generalised_advantages, successor_values

STEPS, ENVS, AGENTS = 23, 5, 3
GAMMA, LAMBDA = 0.97, 0.9


def test_advantages_equal_a_plain_loop() -> None:
    draw = np.random.default_rng(0)
    shape = (STEPS, ENVS, AGENTS)
    rewards, values, terminal_values = (draw.normal(size=shape).astype(np.float32) for _ in range(3))
    last_value = draw.normal(size=(ENVS, AGENTS)).astype(np.float32)
    done = draw.random((STEPS, ENVS)) < 0.3
    truncated = done & (draw.random((STEPS, ENVS)) < 0.5)
    assert (done & ~truncated).any()
    assert truncated.any()

    expected = np.zeros(shape, np.float64)
    for env in range(ENVS):
        for agent in range(AGENTS):
            advantage = 0.0
            following = last_value[env, agent]
            for step in reversed(range(STEPS)):
                if truncated[step, env]:
                    advantage, following = 0.0, terminal_values[step, env, agent]
                elif done[step, env]:
                    advantage, following = 0.0, 0.0
                delta = rewards[step, env, agent] + GAMMA * following - values[step, env, agent]
                advantage = delta + GAMMA * LAMBDA * advantage
                expected[step, env, agent] = advantage
                following = values[step, env, agent]

    successors = successor_values(*map(jnp.asarray, (values, last_value, terminal_values, done, truncated)))
    advantages = generalised_advantages(jnp.asarray(rewards), jnp.asarray(values), successors, jnp.asarray(done), GAMMA, LAMBDA)
    np.testing.assert_allclose(advantages, expected, atol=1e-5)


def test_lambda_one_is_the_discounted_return_less_the_value() -> None:
    rewards = jnp.array([1.0, 2.0, 4.0]).reshape(3, 1, 1)
    values = jnp.array([0.5, 0.25, 0.125]).reshape(3, 1, 1)
    done = jnp.array([[False], [False], [True]])
    successors = successor_values(values, jnp.full((1, 1), 9.0), jnp.full((3, 1, 1), 9.0), done, jnp.zeros((3, 1), bool))
    advantages = generalised_advantages(rewards, values, successors, done, 0.5, 1.0)
    np.testing.assert_allclose(advantages.ravel(), [1 + 1 + 1 - 0.5, 2 + 2 - 0.25, 4 - 0.125])

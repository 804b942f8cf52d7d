"""`examples/ppo_single_file.py`: PPO in one file, beside the bundled trainer."""

import importlib.util
from pathlib import Path
from types import ModuleType

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from sjdsl.trainers import PPOConfig
from sjdsl.trainers.algorithms.advantage import generalised_advantages
from sjdsl.trainers.algorithms.losses import Batch
from sjdsl.trainers.algorithms.ppo import ppo_loss

FILE = Path(__file__).parents[2] / "examples" / "ppo_single_file.py"


@pytest.fixture(scope="module")
def example() -> ModuleType:
    spec = importlib.util.spec_from_file_location("ppo_single_file", FILE)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_its_loss_and_advantages_are_those_of_the_trainer(example: ModuleType) -> None:
    draw = np.random.default_rng(0)
    steps, envs, agents, actions = 6, 4, 2, 5
    shape = (steps, envs, agents)
    reward, value, old = draw.normal(size=(3, *shape)).astype(np.float32)
    last_value = draw.normal(size=shape[1:]).astype(np.float32)
    done = draw.random(shape[:2]) < 0.3
    logits, new_value = (
        draw.normal(size=(*shape, actions)).astype(np.float32),
        draw.normal(size=shape).astype(np.float32),
    )
    action = draw.integers(actions, size=shape)
    rollout = example.Rollout(
        jnp.zeros((*shape, 1, 1, 1)),
        action,
        -np.abs(old),
        value,
        jnp.asarray(reward),
        jnp.asarray(done),
    )

    advantage = example.advantages_of(rollout, last_value)
    following = np.where(done[..., None], 0.0, np.concatenate([value[1:], last_value[None]]))
    expected = generalised_advantages(
        reward, value, following, jnp.asarray(done), example.GAMMA, example.LAMBDA
    )
    np.testing.assert_allclose(advantage, expected, rtol=1e-5, atol=1e-6)

    batch = Batch(
        observation=None, joint=None, fresh=None, memory=(), action=action, log_probability=rollout.log_probability, value=value,
        advantage=advantage, target=value + advantage,
    )  # fmt: skip
    config = PPOConfig(clip_value_loss=False, clip_epsilon=example.CLIP)
    whole, _ = ppo_loss(None, lambda *_: ((), logits, new_value), batch, config)
    np.testing.assert_allclose(
        example.loss_of(None, lambda *_: (logits, new_value), (rollout, advantage)),
        whole,
        rtol=1e-5,
    )


@pytest.mark.thorough
def test_it_learns_coins(example: ModuleType) -> None:
    """Random agents earn about 0 together, and those who learn from the mean of both rewards over 100 of at most about 164."""
    with jax.debug_key_reuse(False):
        returns = example.train("coins", 5e5, say=lambda _: None)
    assert np.mean(returns[:2]) < 20
    assert np.mean(returns[-10:]) > 100

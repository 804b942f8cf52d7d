"""The Stable-Baselines3 adapter: the contract of a `VecEnv`, and PPO trained on it."""

from pathlib import Path

import numpy as np
import pytest
import torch
from sb3_contrib import MaskablePPO
from sb3_contrib.common.maskable.utils import is_masking_supported
from stable_baselines3 import PPO
from stable_baselines3.common.preprocessing import is_image_space, preprocess_obs
from stable_baselines3.common.vec_env import VecMonitor

from sjdsl.interop.gymnasium import AgentGame
from sjdsl.interop.stable_baselines3 import VecGame

LENGTH = 10
SHORT = {"params": {"length": LENGTH}}


def actions_of(env: VecGame, step: int) -> np.ndarray:
    return (3 * step + np.arange(env.num_envs)) % env.env.num_actions


def test_a_step_and_the_end_of_episodes() -> None:
    env = VecGame("coins", 2, **SHORT)
    assert env.num_envs == 4
    assert env.seed(4) == [4] * 4
    observation = env.reset()
    assert observation.shape == (4, *env.observation_space.shape)
    for step in range(LENGTH):
        observation, reward, done, infos = env.step(actions_of(env, step))
        assert reward.shape == done.shape == (4,)
        assert done.tolist() == [step == LENGTH - 1] * 4
    assert all(info["TimeLimit.truncated"] for info in infos)
    assert all(info["terminal_observation"] in env.observation_space for info in infos)
    assert not np.array_equal(
        np.stack([info["terminal_observation"] for info in infos]), observation
    )
    assert {"own_coins", "other_coins"} <= set(infos[0])


def test_ppo_learns_to_eat() -> None:
    """Apples that come back fast: of four seeds each came to 1.6 to 7 times its first returns. Returns are counted by its own monitor."""
    plenty = {"length": 50, "regrow_1": 0.2, "regrow_2": 0.2, "regrow_3": 0.2}
    env = VecMonitor(VecGame("harvest_open", 2, params=plenty))
    model = PPO(
        "MlpPolicy", env, n_steps=50, batch_size=140, n_epochs=6, learning_rate=1e-3, seed=1
    )
    model.learn(50 * 14 * 2)
    early = np.mean([episode["r"] for episode in model.ep_info_buffer])
    model.learn(50 * 14 * 14, reset_num_timesteps=False)
    assert all(episode["l"] == 50 for episode in model.ep_info_buffer)
    late = np.mean([episode["r"] for episode in list(model.ep_info_buffer)[-28:]])
    assert late > 1.3 * early
    assert model.predict(env.reset(), deterministic=True)[0].shape == (14,)


@pytest.mark.parametrize("observation", ["onehot", "tokens"])
def test_observations_reach_networks_as_they_are(observation: str) -> None:
    """By its own preprocessing: not divided by 255, not turned round; the same for one agent's environment of Gymnasium."""
    env = VecGame("coins", 2, observation, **SHORT)
    model = PPO("MlpPolicy", env, n_steps=4, batch_size=4)
    seen = env.reset()
    assert not is_image_space(env.observation_space)
    kept = preprocess_obs(torch.as_tensor(seen), env.observation_space)
    np.testing.assert_array_equal(kept.numpy(), seen)
    assert (kept.max() == 1) == (observation == "onehot")
    assert isinstance(model.get_env(), VecGame)  # wrapped by nothing
    alone = AgentGame("coins", observation=observation, **SHORT)
    assert alone.observation_space == env.observation_space
    assert env.observation_space.contains(seen[0])


def test_masked_actions_are_never_taken() -> None:
    """By `MaskablePPO` of sb3-contrib, in a game that forbids."""
    env = VecGame(str(Path(__file__).parents[1] / "runtime/yard.sj"), 4)
    assert is_masking_supported(env) and is_masking_supported(VecMonitor(env))
    forbidden = []
    step = env.step_async

    def watched(actions: np.ndarray) -> None:
        forbidden.append(~env.action_masks()[np.arange(env.num_envs), actions])
        step(actions)

    env.step_async = watched
    MaskablePPO("MlpPolicy", env, n_steps=16, batch_size=48, n_epochs=1, seed=0).learn(400)
    assert not np.any(forbidden)
    forbidden.clear()
    PPO("MlpPolicy", env, n_steps=16, batch_size=48, n_epochs=1, seed=0).learn(400)
    assert np.any(forbidden)

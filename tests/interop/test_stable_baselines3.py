"""The Stable-Baselines3 adapter: the contract of a `VecEnv`, and PPO trained on it."""

import numpy as np
import pytest
from stable_baselines3 import PPO
from stable_baselines3.common.vec_env import VecMonitor

from sjdsl.interop.stable_baselines3 import VecGame

LENGTH = 10
SHORT = {"params": {"length": LENGTH}}


def actions_of(env: VecGame, step: int) -> np.ndarray:
    return (3 * step + np.arange(env.num_envs)) % env.env.num_actions


def test_a_step_and_the_end_of_episodes() -> None:
    env = VecGame("coins", 2, **SHORT)
    assert env.num_envs == 4
    env.seed(4)
    observation = env.reset()
    assert observation.shape == (4, *env.observation_space.shape)
    for step in range(LENGTH):
        observation, reward, done, infos = env.step(actions_of(env, step))
        assert reward.shape == done.shape == (4,)
        assert done.tolist() == [step == LENGTH - 1] * 4
    assert all(info["TimeLimit.truncated"] for info in infos)
    assert all(info["terminal_observation"] in env.observation_space for info in infos)
    assert not np.array_equal(np.stack([info["terminal_observation"] for info in infos]), observation)
    assert {"own_coins", "other_coins"} <= set(infos[0])


def test_a_seed_holds_for_one_reset() -> None:
    env = VecGame("coins", 2, **SHORT)
    starts = []
    for _ in range(2):
        assert env.seed(4) == [4] * 4
        env.reset()
        starts.append(np.concatenate([env.step(actions_of(env, step))[0] for step in range(3 * LENGTH)]))
    np.testing.assert_array_equal(*starts)
    env.reset()
    assert not np.array_equal(starts[0], np.concatenate([env.step(actions_of(env, step))[0] for step in range(3 * LENGTH)]))


def test_ppo_learns_to_eat() -> None:
    """Apples that come back fast: of four seeds each came to 1.6 to 7 times its first returns. Returns are counted by its own monitor."""
    plenty = {"length": 50, "regrow_1": 0.2, "regrow_2": 0.2, "regrow_3": 0.2}
    env = VecMonitor(VecGame("harvest_open", 2, params=plenty))
    model = PPO("MlpPolicy", env, n_steps=50, batch_size=140, n_epochs=6, learning_rate=1e-3, seed=1)
    model.learn(50 * 14 * 2)
    early = np.mean([episode["r"] for episode in model.ep_info_buffer])
    model.learn(50 * 14 * 14, reset_num_timesteps=False)
    assert all(episode["l"] == 50 for episode in model.ep_info_buffer)
    late = np.mean([episode["r"] for episode in list(model.ep_info_buffer)[-28:]])
    assert late > 1.3 * early
    assert model.predict(env.reset(), deterministic=True)[0].shape == (14,)


def test_what_slots_do_not_have() -> None:
    env = VecGame("coins", 1, **SHORT)
    assert env.get_attr("num_agents") == [2, 2]
    assert env.get_attr("render_mode", [0]) == [None]
    assert env.env_is_wrapped(object) == [False, False]
    with pytest.raises(AttributeError, match="cannot be set for a slot"):
        env.set_attr("length", 3)
    with pytest.raises(AttributeError, match="a slot has no method `play`"):
        env.env_method("play")
    with pytest.raises(RuntimeError, match="call step_async before step_wait"):
        env.step_wait()

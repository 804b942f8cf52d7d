"""PPO of Stable-Baselines3 on a compiled game: one policy for all agents, common reward.

pip install 'sjdsl[sb3]'
"""

from stable_baselines3 import PPO
from stable_baselines3.common.vec_env import VecMonitor

from sjdsl.interop.stable_baselines3 import VecGame


def main(total_timesteps: int = 4096) -> float:
    """Returns the mean return of the last episodes. A time step is one agent's."""
    env = VecMonitor(VecGame("coins", num_envs=4, common_reward=True, params={"length": 50, "spawn": 0.02}))
    model = PPO("MlpPolicy", env, n_steps=64, batch_size=128, seed=0)
    model.learn(total_timesteps)
    last = [episode["r"] for episode in model.ep_info_buffer][-8:]
    mean = sum(last) / len(last)
    print(f"mean return of the last {len(last)} episodes: {mean:.2f}")
    return mean


if __name__ == "__main__":
    main()

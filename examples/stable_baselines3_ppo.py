"""PPO of Stable-Baselines3 on a compiled game: one policy for all agents, common reward, convolutions that fit a window of cells.

pip install 'sjdsl[sb3]'
"""

import torch
from stable_baselines3 import PPO
from stable_baselines3.common.torch_layers import BaseFeaturesExtractor
from stable_baselines3.common.vec_env import VecMonitor

from sjdsl.interop.stable_baselines3 import VecGame


class WindowCNN(BaseFeaturesExtractor):
    """Convolutions for what an agent sees, `[rows, cols, channels]`; the policy's own need pictures of at least 36 pixels a side."""

    def __init__(self, observation_space, features_dim=64):
        super().__init__(observation_space, features_dim)
        rows, cols, depth = observation_space.shape
        layers = []
        for side in (5, 3, 3):
            layers += [torch.nn.Conv2d(depth, 32, side, padding="same"), torch.nn.ReLU()]
            depth = 32
        self.layers = torch.nn.Sequential(
            *layers,
            torch.nn.Flatten(),
            torch.nn.Linear(rows * cols * depth, features_dim),
            torch.nn.ReLU(),
        )

    def forward(self, observations):
        return self.layers(observations.movedim(-1, 1).float())


def main(total_timesteps: int = 1024) -> float:
    """Returns the mean return of the last episodes. A time step is one agent's."""
    env = VecMonitor(
        VecGame("coins", num_envs=4, common_reward=True, params={"length": 50, "spawn": 0.02})
    )
    policy = {"features_extractor_class": WindowCNN}
    model = PPO(
        "CnnPolicy", env, n_steps=64, batch_size=128, n_epochs=4, policy_kwargs=policy, seed=0
    )
    model.learn(total_timesteps)
    last = [episode["r"] for episode in model.ep_info_buffer][-8:]
    mean = sum(last) / len(last)
    print(f"mean return of the last {len(last)} episodes: {mean:.2f}")
    return mean


if __name__ == "__main__":
    main()

"""The figures of one training update: how long its parts took, round by round."""

import statistics
from dataclasses import dataclass
from typing import Literal

Network = Literal["mlp", "cnn"]
Algorithm = Literal["ippo", "mappo", "vdn"]
Sharing = Literal["shared", "per_agent", "by_role"]


@dataclass(frozen=True)
class Split:
    """One update: `num_envs` environments for `num_steps` steps, then what is learnt from it. Seconds by round.

    `environments`: the same rollout under a policy that costs nothing; `rollout`: with the network; `learning`: the gradient
    steps alone; `update`: everything. `flops`: what one update's forward and backward passes need, by XLA's count before it optimises.
    """

    name: str
    num_agents: int
    network: Network
    num_envs: int
    num_steps: int
    compile_s: float
    update: tuple[float, ...]
    environments: tuple[float, ...]
    rollout: tuple[float, ...]
    learning: tuple[float, ...]
    flops: float
    algorithm: Algorithm = "ippo"
    sharing: Sharing = "shared"  # which agents have one network

    @property
    def env_steps_per_s(self) -> float:
        """Of whole updates, in the median round."""
        return self.num_envs * self.num_steps / statistics.median(self.update)

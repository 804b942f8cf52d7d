"""The arrays of one episode."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from sjdsl.replay.recording import Recording

Observation = Literal["tokens", "onehot", "none"]  # how observations are stored, if at all


@dataclass(frozen=True)
class Episode:
    """One episode of T steps.

    observations: `[T + 1, N, planes, rows, cols]` uint8, the first before any action, or None.
    actions: `[T, N]` int32; rewards: `[T, N]` float32, as the game gives them.
    events: counts by name, `[T, N]` or `[T]` int32.
    terminated: whether the rules ended it; truncated: whether its length did.
    why: `[T, N]` text, what each agent gave as its reason; None if none was asked.
    """

    seed: int
    observations: np.ndarray | None
    actions: np.ndarray
    rewards: np.ndarray
    events: Mapping[str, np.ndarray]
    terminated: bool
    truncated: bool
    why: np.ndarray | None = None

    @property
    def returns(self) -> np.ndarray:
        """`[N]` float64, the sum of each agent's rewards."""
        return np.asarray(self.rewards.astype(np.float64).sum(axis=0))

    def recording(self, environment: Mapping[str, Any], game_hash: str) -> Recording:
        """Returns the episode as a recording. `environment`: the arguments of `sjdsl.make`."""
        return Recording(
            environment=dict(environment),
            hash=game_hash,
            seed=self.seed,
            actions=self.actions.tolist(),
            returns=self.returns.tolist(),
            why=None if self.why is None else self.why.tolist(),
        )

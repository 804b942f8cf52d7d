"""Gymnasium: a compiled game as a vector environment whose sub-environments are single agents."""

from typing import Any

import numpy as np

from sjdsl.interop.missing import needs
from sjdsl.interop.slots import Slots, SlotStep

with needs("gymnasium"):
    from gymnasium import spaces
    from gymnasium.vector import AutoresetMode, VectorEnv
    from gymnasium.vector.utils import batch_space


class VectorGame(VectorEnv):
    """`num_envs` environments of a game; sub-environment `b * num_agents + i` is agent i of environment b.

    Autoreset happens in the same step: `observations` are those of the new episode, the last ones of the old episode are in
    `infos["final_obs"]`. Rewards are raw, float64. Infos have the events of the step.
    """

    metadata = {"autoreset_mode": AutoresetMode.SAME_STEP, "render_modes": []}  # noqa: RUF012, as Gymnasium has it

    def __init__(self, game: str, num_envs: int = 1, observation: str = "onehot", common_reward: bool = False, **arguments: Any) -> None:
        """Makes the environments.

        Args:
          game, observation, arguments: of `sjdsl.make`.
          num_envs: environments of the game; Gymnasium's `num_envs` of the result is this times the number of agents.
          common_reward: every agent is paid the sum of its environment's rewards.
        """
        self._slots = Slots(game, num_envs, observation, common_reward, **arguments)
        self.env = self._slots.env
        self.num_envs = self._slots.num_slots
        self.single_observation_space = spaces.Box(0, 255, self._slots.window, np.uint8)
        self.single_action_space = spaces.Discrete(self.env.num_actions)
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[np.ndarray, dict[str, Any]]:
        """Starts all episodes. The same seed, one number, gives the same episodes under the same actions."""
        del options
        if seed is not None and not isinstance(seed, int | np.integer):
            raise TypeError(f"the seed is one number for all environments, not {seed!r}")
        super().reset(seed=None if seed is None else int(seed))
        return self._slots.reset(seed), {}

    def step(self, actions: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """Plays one step; an action out of range is refused."""
        if self.closed:
            raise RuntimeError("the environment is closed")
        made = self._slots.step(actions)
        return made.observations, made.rewards.astype(np.float64), made.terminated, made.truncated, self._infos(made)

    def _infos(self, made: SlotStep) -> dict[str, Any]:
        """Returns arrays by name, each with `_name`, where it holds, as Gymnasium's own vector environments have them."""
        every = np.ones(self.num_envs, bool)
        ended = np.zeros(self.num_envs, bool)
        ended[list(made.final)] = True
        going = dict(made.events) | {f"_{name}": every & ~ended for name in made.events}
        if not made.final:
            return going
        last = np.full(self.num_envs, None, object)
        for slot, observation in made.final.items():
            last[slot] = observation
        events = dict(made.events) | {f"_{name}": ended for name in made.events}
        return going | {"final_obs": last, "_final_obs": ended, "final_info": events, "_final_info": ended}

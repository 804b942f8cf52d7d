"""Stable-Baselines3 adapter: a compiled game as a `VecEnv` with one slot for each agent of each environment."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from sjdsl.interop.missing import needs
from sjdsl.interop.slots import Slots
from sjdsl.runtime.env import Encoding

with needs("sb3"):
    from gymnasium import spaces
    from stable_baselines3.common.vec_env import VecEnv
    from stable_baselines3.common.vec_env.base_vec_env import VecEnvIndices, VecEnvStepReturn


class VecGame(VecEnv):
    """`num_envs` environments of a game; slot `b * num_agents + i` is agent i of environment b.

    One policy plays all slots: parameters are shared. At an episode's end the observation is that of the next episode, and the slot's
    info has `terminal_observation` and `TimeLimit.truncated`, from which Stable-Baselines3 bootstraps. Rewards are raw.
    """

    def __init__(
        self, game: str, num_envs: int = 1, observation: Encoding = "onehot", common_reward: bool = False, **arguments: Any
    ) -> None:
        """Makes the environments.

        Args:
          game, observation, arguments: of `sjdsl.make`.
          num_envs: environments of the game; `num_envs` of the result is this times the number of agents.
          common_reward: every agent is paid the sum of its environment's rewards.
        """
        self._slots = Slots(game, num_envs, observation, common_reward, **arguments)
        self.env = self._slots.env
        self.render_mode = None
        self._actions: np.ndarray | None = None
        self._seed: int | None = None
        box = spaces.Box(0, 255, self._slots.window, np.uint8)
        super().__init__(self._slots.num_slots, box, spaces.Discrete(self.env.num_actions))

    def reset(self) -> np.ndarray:
        """Starts all episodes; a seed given before by `seed` holds once."""
        seed, self._seed = self._seed, None
        self.reset_infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        return self._slots.reset(seed)

    def step_async(self, actions: np.ndarray) -> None:
        """Keeps the actions for `step_wait`."""
        self._actions = actions

    def step_wait(self) -> VecEnvStepReturn:
        """Plays one step of every environment."""
        if self._actions is None:
            raise RuntimeError("call step_async before step_wait")
        actions, self._actions = self._actions, None
        made = self._slots.step(actions)
        infos: list[dict[str, Any]] = [{name: int(count[slot]) for name, count in made.events.items()} for slot in range(self.num_envs)]
        for slot, observation in made.final.items():
            infos[slot] |= {"terminal_observation": observation, "TimeLimit.truncated": bool(made.truncated[slot])}
        return made.observations, made.rewards, made.terminated | made.truncated, infos

    def seed(self, seed: int | None = None) -> Sequence[int | None]:
        """Sets the seed of the next reset, one number for all slots."""
        self._seed = seed
        return [seed] * self.num_envs

    def close(self) -> None:
        """Nothing is held open."""

    def get_attr(self, attr_name: str, indices: VecEnvIndices = None) -> list[Any]:
        """Returns an attribute of this object or of the game's environment, once for each slot asked for."""
        owner = self if attr_name in vars(self) else self.env
        return [getattr(owner, attr_name) for _ in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: VecEnvIndices = None) -> None:
        """Slots are one program and have no attributes of their own."""
        del value, indices
        raise AttributeError(f"`{attr_name}` cannot be set for a slot: make the environment with other arguments")

    def env_method(self, method_name: str, *method_args: Any, indices: VecEnvIndices = None, **method_kwargs: Any) -> list[Any]:
        """Slots are one program and have no methods of their own."""
        del method_args, indices, method_kwargs
        raise AttributeError(f"a slot has no method `{method_name}`")

    def env_is_wrapped(self, wrapper_class: type, indices: VecEnvIndices = None) -> list[bool]:
        """Slots are never wrapped."""
        del wrapper_class
        return [False for _ in self._get_indices(indices)]

"""Stable-Baselines3 adapter: a compiled game as a `VecEnv`.

It has one slot for each agent of each environment.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from sjdsl.extras import needs
from sjdsl.interop.calls import checked_seed
from sjdsl.runtime.env import Encoding

with needs("sb3"):
    from stable_baselines3.common.vec_env import VecEnv
    from stable_baselines3.common.vec_env.base_vec_env import VecEnvIndices, VecEnvStepReturn

    from sjdsl.interop.gymnasium import VectorGame

MASKS = "action_masks"


class VecGame(VecEnv):
    """`num_envs` environments of a game; slot `b * num_agents + i` is agent i of environment b.

    Observations are `[rows, cols, channels]` uint8 with their own bounds, so that Stable-Baselines3
    uses them unchanged and stacks frames along the channels. (Observations with the bounds 0 and
    255 would be treated as pictures, divided by 255 and transposed.) One policy plays all slots:
    parameters are shared. At an episode's end the observation is that of the next episode, and the
    slot's info has `terminal_observation` and `TimeLimit.truncated`, from which Stable-Baselines3
    bootstraps. Rewards are raw.

    Attributes:
      env: the `sjdsl.Environment`.
    """

    def __init__(
        self,
        game: str,
        num_envs: int = 1,
        observation: Encoding = "onehot",
        common_reward: bool = False,
        **arguments: Any,
    ) -> None:
        """Makes the environments.

        The arguments are those of `sjdsl.interop.gymnasium.VectorGame`.
        """
        self._vector = VectorGame(game, num_envs, observation, common_reward, **arguments)
        self.env = self._vector.env
        self.render_mode = None
        self._actions: np.ndarray | None = None
        self._seed: int | None = None
        super().__init__(
            self._vector.num_envs,
            self._vector.single_observation_space,
            self._vector.single_action_space,
        )

    def reset(self) -> np.ndarray:
        """Starts all episodes; a seed set by `seed` is used once."""
        self.reset_infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        observations, _ = self._vector.reset(seed=self._seed)
        self._seed = None
        return observations

    def step_async(self, actions: np.ndarray) -> None:
        """Stores the actions for `step_wait`."""
        self._actions = actions

    def step_wait(self) -> VecEnvStepReturn:
        """Plays one step of every environment."""
        if self._actions is None:
            raise RuntimeError("call step_async before step_wait")
        observations, rewards, terminated, truncated, arrays = self._vector.step(self._actions)
        self._actions = None
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        for slot in np.nonzero(terminated | truncated)[0]:
            infos[slot]["terminal_observation"] = arrays["final_obs"][slot]
            infos[slot]["TimeLimit.truncated"] = bool(truncated[slot])
        for name, counts in arrays.items():
            if name.startswith("_") or name in ("final_obs", "final_info"):
                continue
            for info, count in zip(infos, counts, strict=True):
                info[name] = int(count)
        return observations, rewards.astype(np.float32), terminated | truncated, infos

    def seed(self, seed: int | None = None) -> Sequence[int | None]:
        """Sets the seed of the next reset, one number for all slots.

        Raises the errors of `sjdsl.interop.calls.checked_seed`.
        """
        self._seed = checked_seed(seed)
        return [seed] * self.num_envs

    def action_masks(self) -> np.ndarray:
        """Returns which actions each slot may take next, `[num_envs, num_actions]` bool."""
        return self._vector.action_masks()

    def close(self) -> None:
        """Does nothing: there is nothing to release."""

    def get_attr(self, attr_name: str, indices: VecEnvIndices = None) -> list[Any]:
        """Returns an attribute of this object or of the game's environment.

        Once for each requested slot.
        """
        owner = self if attr_name in vars(self) or attr_name == MASKS else self.env
        return [getattr(owner, attr_name) for _ in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: VecEnvIndices = None) -> None:
        """Raises AttributeError: slots are one program and have no attributes of their own."""
        del value, indices
        raise AttributeError(
            f"`{attr_name}` can't be set for a slot: make the environment with other arguments"
        )

    def env_method(
        self,
        method_name: str,
        *method_args: Any,
        indices: VecEnvIndices = None,
        **method_kwargs: Any,
    ) -> list[Any]:
        """Calls `action_masks`, as `MaskablePPO` of sb3-contrib does.

        Raises AttributeError for any other method: slots are one program and have no methods.
        """
        if method_name == MASKS and not method_args and not method_kwargs:
            return list(self.action_masks()[list(self._get_indices(indices))])
        raise AttributeError(
            f"a slot has no method `{method_name}`, only `{MASKS}`, which takes no arguments"
        )

    def env_is_wrapped(self, wrapper_class: type, indices: VecEnvIndices = None) -> list[bool]:
        """Slots are never wrapped."""
        del wrapper_class
        return [False for _ in self._get_indices(indices)]

"""Gymnasium adapter: a compiled game as a vector environment with one sub-environment an agent, or for one agent."""

from typing import Any

import numpy as np

from sjdsl.extras import needs
from sjdsl.interop.calls import by_name, checked_seed
from sjdsl.interop.slots import Autoreset, Slots, SlotStep
from sjdsl.interop.spaces import window_high
from sjdsl.library.games_folder import game_names
from sjdsl.runtime.env import Encoding

with needs("gymnasium"):
    import gymnasium
    from gymnasium import spaces
    from gymnasium.vector import AutoresetMode, VectorEnv
    from gymnasium.vector.utils import batch_space

from sjdsl.interop.gymnasium_agent import AgentGame

__all__ = ["AgentGame", "VectorGame", "environment_id"]

MODES: dict[AutoresetMode, Autoreset] = {
    AutoresetMode.SAME_STEP: "same step",
    AutoresetMode.NEXT_STEP: "next step",
    AutoresetMode.DISABLED: "never",
}


class VectorGame(VectorEnv):
    """`num_envs` environments of a game; sub-environment `b * num_agents + i` is agent i of environment b.

    Autoreset happens in the same step unless another mode is chosen: `observations` are those of the new episode, the last ones of
    the old episode are in `infos["final_obs"]`. Rewards are raw, float64. Infos have the events of the step.
    """

    metadata = {"autoreset_mode": AutoresetMode.SAME_STEP, "render_modes": []}  # noqa: RUF012, as Gymnasium has it

    def __init__(
        self,
        game: str,
        num_envs: int = 1,
        observation: Encoding = "onehot",
        common_reward: bool = False,
        autoreset_mode: AutoresetMode | str = AutoresetMode.SAME_STEP,
        **arguments: Any,
    ) -> None:
        """Makes the environments.

        Args:
          game, observation, arguments: of `sjdsl.make`.
          num_envs: environments of the game; Gymnasium's `num_envs` of the result is this times the number of agents.
          common_reward: whether every agent gets the sum of its environment's rewards.
          autoreset_mode: Gymnasium's, or its name: `SAME_STEP`; `NEXT_STEP`, in which the step after an episode's last begins the next
            one, whatever the actions; `DISABLED`, in which only `reset` does, for all or for `options={"reset_mask": …}`.
        Raises:
          ValueError: there is no such mode.
        """
        mode = _mode(autoreset_mode)
        self.metadata = {**type(self).metadata, "autoreset_mode": mode}
        self._slots = Slots(game, num_envs, observation, common_reward, MODES[mode], **arguments)
        self.env = self._slots.env
        self.num_envs = self._slots.num_slots
        self.single_observation_space = spaces.Box(0, window_high(self.env), dtype=np.uint8)
        self.single_action_space = spaces.Discrete(self.env.num_actions)
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[np.ndarray, dict[str, Any]]:
        """Starts all episodes, or those in `options["reset_mask"]`, `[num_envs]` bool; returns the observations of all.

        The same seed, one number, gives the same episodes under the same actions.

        Raises:
          TypeError: the seed isn't one whole number, or there is another option.
          ValueError: the seed is negative, or the mask has only some of the agents of an environment.
        """
        given = dict(options or {})
        chosen = given.pop("reset_mask", None)
        if given:
            raise TypeError(f"there is no option `{next(iter(given))}`; the only option is `reset_mask`")
        super().reset(seed=checked_seed(seed))
        return self._slots.reset(seed, chosen), {}

    def step(self, actions: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """Plays one step. Raises TypeError or ValueError for an action that isn't a whole number or is out of range."""
        if self.closed:
            raise RuntimeError("the environment is closed")
        made = self._slots.step(actions)
        return made.observations, made.rewards.astype(np.float64), made.terminated, made.truncated, self._infos(made)

    def action_masks(self) -> np.ndarray:
        """Returns which actions each agent may take next, `[num_envs, num_actions]` bool."""
        return self._slots.action_masks()

    def _infos(self, made: SlotStep) -> dict[str, Any]:
        """Returns arrays by name, each with `_name`, where it holds, as Gymnasium's own vector environments have them."""
        counts, every = by_name(made.events), np.ones(self.num_envs, bool)
        ended = np.zeros(self.num_envs, bool)
        ended[list(made.final)] = True
        going = counts | {f"_{name}": every & ~ended & ~made.began for name in counts}
        if not made.final:
            return going
        last = np.full(self.num_envs, None, object)
        for slot, observation in made.final.items():
            last[slot] = observation
        events = counts | {f"_{name}": ended for name in counts}
        return going | {"final_obs": last, "_final_obs": ended, "final_info": events, "_final_info": ended}


def environment_id(game: str) -> str:
    """Returns the id of a game in Gymnasium's registry: `sjdsl/CleanUp-v0` for `clean_up`."""
    return f"sjdsl/{''.join(word.capitalize() for word in game.split('_'))}-v0"


def _mode(given: AutoresetMode | str) -> AutoresetMode:
    named = {mode.name: mode for mode in AutoresetMode} | {mode.value: mode for mode in AutoresetMode}
    mode = given if isinstance(given, AutoresetMode) else named.get(str(given))
    if mode is None:
        raise ValueError(f"there is no autoreset mode {given!r}; they are {', '.join(mode.name for mode in AutoresetMode)}")
    return mode


for _name in game_names():  # `gymnasium.make("sjdsl/CleanUp-v0")`, once this module is imported
    if environment_id(_name) not in gymnasium.registry:
        gymnasium.register(environment_id(_name), "sjdsl.interop.gymnasium_agent:AgentGame", kwargs={"game": _name})

"""PettingZoo adapter: a compiled game as a `ParallelEnv`."""

from collections.abc import Mapping
from typing import Any

import jax
import numpy as np

from sjdsl.extras import needs
from sjdsl.interop.calls import action_masks, by_name, numbers_of_actions, seeded_key
from sjdsl.interop.copies import Copied
from sjdsl.interop.drawing import RENDER_MODES, Drawing
from sjdsl.interop.spaces import window_high
from sjdsl.library.factory import make
from sjdsl.library.games_folder import bundled
from sjdsl.runtime.env import Encoding

with needs("pettingzoo"):
    from gymnasium import spaces
    from pettingzoo import ParallelEnv, register

Infos = dict[str, dict[str, Any]]


class ParallelGame(Copied, ParallelEnv):
    """One environment of a game; agents are `agent_0`, `agent_1` and so on, and all leave together.

    Observations are `[rows, cols, channels]` uint8, one-hot unless `observation="tokens"`; rewards
    are raw. An episode ends by truncation, or by termination where the rules say `end`. Infos have
    the events of the step, and `action_mask`, `[num_actions]` int8, the actions that are allowed
    next. An action out of range raises ValueError. Environments can be copied and pickled with
    their state.
    """

    KEPT = ("_key", "_state", "_returns", "agents")
    metadata = {  # noqa: RUF012
        "name": "sjdsl_v0",
        "render_modes": list(RENDER_MODES),
        "is_parallelizable": True,
    }

    def __init__(
        self,
        game: str,
        render_mode: str | None = None,
        observation: Encoding = "onehot",
        **arguments: Any,
    ) -> None:
        """Makes the environment.

        Args:
          game, observation, arguments: of `sjdsl.make`.
          render_mode: None; `human`, the board in the terminal after each step; `ansi`, the same as
            a text; `rgb_array`, a picture.
        """
        self.env = make(game, observation=observation, **arguments)
        self.metadata = {**type(self).metadata, "name": f"{self.env.name}_v0"}
        self.render_mode = render_mode
        self.possible_agents = [f"agent_{index}" for index in range(self.env.num_agents)]
        self.agents: list[str] = []
        self.observation_spaces = dict.fromkeys(
            self.possible_agents, spaces.Box(0, window_high(self.env), dtype=np.uint8)
        )
        self.action_spaces = {
            agent: spaces.Discrete(self.env.num_actions) for agent in self.possible_agents
        }
        _, state = jax.eval_shape(self.env.reset, jax.random.key(0))
        shape = jax.eval_shape(self.env.state_vector, state).shape
        self.state_space = spaces.Box(-1.0, 1.0, shape, np.float32)
        self._jitted_state_vector = jax.jit(self.env.state_vector)
        self._jitted_allowed = jax.jit(self.env.allowed_actions)
        self._key: Any = None
        self._state: Any = None
        self._returns = np.zeros(self.env.num_agents)
        self._drawing = Drawing(self.env, render_mode)

    def observation_space(self, agent: str) -> spaces.Space:
        """Returns the same object at each call."""
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> spaces.Space:
        """Returns the same object at each call."""
        return self.action_spaces[agent]

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, np.ndarray], Infos]:
        """Starts an episode.

        The same seed gives the same episode under the same actions; without one, the random draws
        continue.
        """
        del options
        if seed is not None or self._key is None:
            self._key = seeded_key(seed)
        self._key, reset_key = jax.random.split(self._key)
        observation, self._state = self.env.reset(reset_key)
        self._returns = np.zeros(self.env.num_agents)
        self.agents = self.possible_agents[:]
        if self.render_mode == "human":
            self.render()
        infos = {agent: {"action_mask": mask} for agent, mask in self._masks().items()}
        return self._by_agent(_channels_last(observation)), infos

    def step(
        self, actions: Mapping[str, int]
    ) -> tuple[dict[str, np.ndarray], dict[str, float], dict[str, bool], dict[str, bool], Infos]:
        """Plays one step; without agents, after an episode's end, nothing happens."""
        if not self.agents:
            if self._state is None:
                raise RuntimeError("call reset before step")
            return {}, {}, {}, {}, {}
        missing = [agent for agent in self.agents if agent not in actions]
        if missing:
            raise KeyError(
                f"no action for {missing[0]}; give one for each of {', '.join(self.agents)}"
            )
        chosen = numbers_of_actions(
            [actions[agent] for agent in self.agents],
            self.env.num_actions,
            lambda i: f" of {self.agents[i]}",
        )
        self._key, step_key = jax.random.split(self._key)
        observation, self._state, reward, done, info = self.env.step_env(
            step_key, self._state, chosen
        )
        rewards = np.asarray(reward, np.float64)
        self._returns = self._returns + rewards
        infos: Infos = {agent: {} for agent in self.agents}
        for name, count in by_name(info["events"]).items():
            counts = np.broadcast_to(count, (len(self.agents),))
            for agent, number in zip(self.agents, counts, strict=True):
                infos[agent][name] = int(number)
        for agent, mask in self._masks().items():
            infos[agent]["action_mask"] = mask
        results = (
            self._by_agent(_channels_last(observation)),
            {agent: float(value) for agent, value in zip(self.agents, rewards, strict=True)},
            dict.fromkeys(self.agents, bool(info["terminated"])),
            dict.fromkeys(self.agents, bool(info["truncated"])),
            infos,
        )
        if bool(done):
            self.agents = []
        if self.render_mode == "human":
            self.render()
        return results

    def state(self) -> np.ndarray:
        """Returns the whole state as one vector, `[K]` float32."""
        if self._state is None:
            raise RuntimeError("call reset before state")
        return np.asarray(self._jitted_state_vector(self._state))

    def render(self) -> np.ndarray | str | None:
        """Returns the state as a picture `[height, width, 3]` uint8 or as a text.

        Prints the text and returns None in mode `human`.
        """
        return self._drawing.draw(self._state, self._returns)

    def close(self) -> None:
        """Does nothing: there is nothing to release."""

    def _masks(self) -> dict[str, np.ndarray]:
        """Returns the actions that are allowed next, by agent."""
        masks = action_masks(self.env, self._state, self._jitted_allowed)
        return self._by_agent(masks.astype(np.int8))

    def _by_agent(self, values: np.ndarray) -> dict[str, np.ndarray]:
        return dict(zip(self.agents, values, strict=True))


def parallel_env(game: str, **arguments: Any) -> ParallelGame:
    """Returns `ParallelGame(game, …)`, under the name that PettingZoo's tools look for."""
    return ParallelGame(game, **arguments)


def _channels_last(observation: Any) -> np.ndarray:
    """Returns `[N, rows, cols, channels]` of `[N, channels, rows, cols]`."""
    return np.ascontiguousarray(np.moveaxis(np.asarray(observation), 1, -1))


# `pettingzoo.make("parallel", "sjdsl/coins-v0")` works once this module is imported.
for _name in bundled():
    register("parallel", f"sjdsl/{_name}-v0", f"{__name__}:parallel_env", kwargs={"game": _name})

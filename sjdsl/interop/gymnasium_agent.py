"""Gymnasium environment of one agent of a compiled game, while a policy controls the others."""

from os import PathLike
from pathlib import Path
from typing import Any

import jax
import numpy as np

from sjdsl.extras import needs
from sjdsl.interop.calls import by_name, checked_seed, numbers_of_actions
from sjdsl.interop.copies import Copied
from sjdsl.interop.drawing import RENDER_MODES, Drawing
from sjdsl.interop.spaces import window_high
from sjdsl.library.factory import make
from sjdsl.runtime.env import Encoding, Environment
from sjdsl.runtime.policy import UNTRAINED, Policy, take_actions, with_memory

with needs("gymnasium"):
    import gymnasium
    from gymnasium import spaces

FRAMES = 8  # a second, when an episode is shown


class AgentGame(Copied, gymnasium.Env):
    """One environment of a game as one of its agents sees it, whose actions the caller chooses.

    Observations are `[rows, cols, channels]` uint8, one-hot unless `observation="tokens"`. The
    reward is the agent's own, raw. Infos: the events of the step for this agent, by name;
    `action_mask`, `[num_actions]` int8, the actions that are allowed; `rewards`, `[num_agents]`
    float32, of everybody. An episode ends by truncation, or by termination where the rules say
    `end`.

    Attributes:
      env: the `sjdsl.Environment`; agent: the number of the controlled agent.
    """

    KEPT = (
        "_key",
        "_state",
        "_memory",
        "_is_over",
        "_returns",
        "_np_random",
        "_np_random_seed",
        "spec",
    )
    metadata = {"render_modes": list(RENDER_MODES), "render_fps": FRAMES}  # noqa: RUF012

    def __init__(
        self,
        game: str,
        agent: int = 0,
        others: str | PathLike[str] | Policy = "random",
        observation: Encoding = "onehot",
        render_mode: str | None = None,
        **arguments: Any,
    ) -> None:
        """Makes the environment.

        Args:
          game, observation, arguments: of `sjdsl.make`.
          agent: the number of the controlled agent.
          others: the policy of the other agents: `random`, `stay`, the folder of a training run,
            the `.safetensors` file of a policy, or any other name of one
            (`sjdsl.trainers.find_policy`); or a function `(key, observation) -> actions
            [num_agents]` that can be jitted, whose observations are tokens of all agents.
          render_mode: None; `human`, the board in the terminal after each step; `ansi`, the same as
            a text; `rgb_array`, a picture.
        Raises:
          ValueError: there is no such agent or mode. PolicyError: there is no policy `others`, or
            it is for another game.
        """
        self.env = make(game, observation=observation, **arguments)
        if not 0 <= agent < self.env.num_agents:
            raise ValueError(
                f"{self.env.name} has no agent {agent}; "
                f"its agents are 0 to {self.env.num_agents - 1}"
            )
        self.agent = agent
        self.render_mode = render_mode
        self.spec = None
        self.observation_space = spaces.Box(0, window_high(self.env), dtype=np.uint8)
        self.action_space = spaces.Discrete(self.env.num_actions)
        self._np_random = None
        self._np_random_seed = None
        self._token_env = make(game, observation="tokens", **arguments)
        self._others = with_memory(_policy_of(others, self._token_env))
        self._jitted_reset = jax.jit(self._reset)
        self._jitted_step = jax.jit(self._step)
        self._key: Any = None
        self._state: Any = None
        self._memory: Any = None
        self._is_over = True
        self._returns = np.zeros(self.env.num_agents)
        self._drawing = Drawing(self.env, render_mode)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Starts an episode.

        The same seed gives the same episode, and the same ones after it, under the same actions.
        """
        del options
        super().reset(seed=checked_seed(seed))
        self._key = jax.random.key(int(self.np_random.integers(2**32)))
        self._key, observation, self._state, mask = self._jitted_reset(self._key)
        self._memory = self._others.start
        self._is_over = False
        self._returns = np.zeros(self.env.num_agents)
        if self.render_mode == "human":
            self.render()
        return np.array(observation), {"action_mask": np.array(mask)}

    def step(self, action: int) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        """Plays one step.

        Raises:
          RuntimeError: no episode has been started. TypeError: the action isn't a whole number.
          ValueError: it is out of range.
        """
        if self._is_over:
            raise RuntimeError("the episode is over or not started; call reset")
        number = numbers_of_actions([action], self.env.num_actions, lambda _: "")[0]
        self._key, self._memory, observation, self._state, reward, info = self._jitted_step(
            self._key, self._memory, self._state, number
        )
        rewards = np.array(reward)
        self._returns = self._returns + rewards
        terminated = bool(info["terminated"])
        truncated = bool(info["truncated"])
        self._is_over = terminated or truncated
        if self.render_mode == "human":
            self.render()
        infos: dict[str, Any] = {
            name: int(count) for name, count in by_name(info["events"]).items()
        }
        infos["action_mask"] = np.array(info["action_mask"])
        infos["rewards"] = rewards
        return np.array(observation), float(rewards[self.agent]), terminated, truncated, infos

    def action_masks(self) -> np.ndarray:
        """Returns the actions that are allowed next, `[num_actions]` bool.

        `MaskablePPO` of sb3-contrib calls it.
        """
        if self._state is None:
            raise RuntimeError("call reset before action_masks")
        return np.asarray(self.env.allowed_actions(self._state)[self.agent])

    def render(self) -> np.ndarray | str | None:
        """Returns the state as a picture `[height, width, 3]` uint8 or as a text.

        Prints the text and returns None in mode `human`.
        """
        return self._drawing.draw(self._state, self._returns)

    def _reset(self, key: Any) -> tuple[Any, Any, Any, Any]:
        """Returns the next key, then observation, state and action mask of a new episode."""
        key, reset_key = jax.random.split(key)
        observation, state = self.env.reset(reset_key)
        return key, self._window(observation), state, self._mask(state)

    def _step(
        self, key: Any, memory: Any, state: Any, action: Any
    ) -> tuple[Any, Any, Any, Any, Any, dict[str, Any]]:
        """Returns the next key and memory, then observation, state, rewards and infos."""
        key, others_key, step_key = jax.random.split(key, 3)
        tokens = self._token_env.observe(state)
        memory, actions = take_actions(self.env, self._others, memory, others_key, tokens, state)
        actions = actions.at[self.agent].set(action)
        observation, state, reward, _, info = self.env.step_env(step_key, state, actions)
        memory = self._others.after_step(memory, actions, reward, info)
        infos = {
            "events": {
                name: count[self.agent] if count.ndim else count
                for name, count in info["events"].items()
            },
            "terminated": info["terminated"],
            "truncated": info["truncated"],
            "action_mask": self._mask(state),
        }
        return key, memory, self._window(observation), state, reward, infos

    def _window(self, observation: Any) -> Any:
        """Returns `[rows, cols, channels]` of `[N, channels, rows, cols]`."""
        return jax.numpy.moveaxis(observation[self.agent], 0, -1)

    def _mask(self, state: Any) -> Any:
        return self.env.allowed_actions(state)[self.agent].astype(np.int8)


def _policy_of(policy: str | PathLike[str] | Policy, env: Environment) -> Policy:
    """Returns the policy that the argument `others` means."""
    if isinstance(policy, str) and policy in UNTRAINED:
        return UNTRAINED[policy](env)
    from sjdsl.trainers import find_policy

    return find_policy(Path(policy) if isinstance(policy, PathLike) else policy, env)

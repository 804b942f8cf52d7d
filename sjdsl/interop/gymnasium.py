"""Gymnasium adapter: a compiled game as a vector environment, or as one of one agent.

A vector environment has a sub-environment for each agent.
"""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from sjdsl.extras import needs
from sjdsl.interop.calls import action_masks, by_name, checked_seed, numbers_of_actions, seeded_key
from sjdsl.interop.copies import Copied
from sjdsl.interop.spaces import window_high
from sjdsl.library.factory import make
from sjdsl.library.games_folder import bundled
from sjdsl.runtime.env import Encoding

with needs("gymnasium"):
    import gymnasium
    from gymnasium import spaces
    from gymnasium.vector import AutoresetMode, VectorEnv
    from gymnasium.vector.utils import batch_space

from sjdsl.interop.gymnasium_agent import AgentGame

__all__ = ["AgentGame", "VectorGame", "environment_id"]


class VectorGame(Copied, VectorEnv):
    """`num_envs` environments of a game.

    Sub-environment (slot) `b * num_agents + i` is agent i of environment b.

    Autoreset happens in the same step: `observations` are those of the new episode, the last ones
    of the old episode are in `infos["final_obs"]`. Rewards are raw, float64. Infos have the events
    of the step.

    Attributes:
      env: the `sjdsl.Environment`.
    """

    KEPT = ("_key", "_state", "closed", "_np_random", "_np_random_seed")
    metadata = {"autoreset_mode": AutoresetMode.SAME_STEP, "render_modes": []}  # noqa: RUF012

    def __init__(
        self,
        game: str,
        num_envs: int = 1,
        observation: Encoding = "onehot",
        common_reward: bool = False,
        **arguments: Any,
    ) -> None:
        """Makes the environments.

        Args:
          game, observation, arguments: of `sjdsl.make`.
          num_envs: environments of the game; Gymnasium's `num_envs` of the result is this times the
            number of agents.
          common_reward: whether every agent gets the sum of its environment's rewards.
        Raises:
          ValueError: `num_envs` is less than 1.
        """
        if num_envs < 1:
            raise ValueError(f"num_envs must be at least 1, not {num_envs}")
        self.env = make(game, observation=observation, **arguments)
        self._shape = (num_envs, self.env.num_agents)
        self.num_envs = num_envs * self.env.num_agents
        self.single_observation_space = spaces.Box(0, window_high(self.env), dtype=np.uint8)
        self.single_action_space = spaces.Discrete(self.env.num_actions)
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self.closed = False
        self._common_reward = common_reward
        self._np_random = None
        self._np_random_seed = None
        self._key: Any = None
        self._state: Any = None
        self._jitted_reset = jax.jit(self._reset)
        self._jitted_step = jax.jit(self._step)
        self._jitted_observe = jax.jit(jax.vmap(self.env.observe))
        self._jitted_allowed = jax.jit(jax.vmap(self.env.allowed_actions))

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Starts all episodes.

        The same seed, one number, gives the same episodes under the same actions. Without a seed,
        the random draws continue; the first time, the seed is random.

        Raises:
          TypeError: the seed isn't one whole number, or there is an option. ValueError: the seed is
            negative.
        """
        if options:
            raise TypeError(f"there is no option `{next(iter(options))}`")
        super().reset(seed=checked_seed(seed))
        if seed is not None or self._key is None:
            self._key = seeded_key(seed)
        self._key, observation, self._state = self._jitted_reset(self._key)
        return self._windows(observation), {}

    def step(
        self, actions: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """Plays one step of every environment.

        Raises:
          RuntimeError: before the first reset, or after `close`.
          TypeError: the actions aren't whole numbers. ValueError: they have another shape, or one
            is out of range.
        """
        if self.closed:
            raise RuntimeError("the environment is closed")
        if self._state is None:
            raise RuntimeError("call reset before step")
        actions = np.asarray(actions)
        if actions.shape != (self.num_envs,):
            raise ValueError(f"expected actions of shape ({self.num_envs},), got {actions.shape}")
        numbers = numbers_of_actions(actions, self.env.num_actions, lambda slot: f" of slot {slot}")
        self._key, observation, self._state, reward, info = self._jitted_step(
            self._key, self._state, numbers.reshape(self._shape)
        )
        terminated = np.repeat(info["terminated"], self.env.num_agents)
        truncated = np.repeat(info["truncated"], self.env.num_agents)
        counts = {name: np.asarray(count).reshape(-1) for name, count in info["events"].items()}
        return (
            self._windows(observation),
            np.asarray(reward, np.float64).reshape(-1),
            terminated,
            truncated,
            self._infos(by_name(counts), terminated | truncated, info["terminal_state"]),
        )

    def action_masks(self) -> np.ndarray:
        """Returns which actions each agent may take next, `[num_envs, num_actions]` bool.

        Raises RuntimeError before the first reset.
        """
        if self._state is None:
            raise RuntimeError("call reset before action_masks")
        masks = action_masks(self.env, self._state, self._jitted_allowed)
        return masks.reshape(self.num_envs, -1)

    def _infos(
        self, counts: dict[str, np.ndarray], ended: np.ndarray, last_states: Any
    ) -> dict[str, Any]:
        """Returns arrays by name, in the form of Gymnasium's vector environments.

        The array `_NAME` says in which slots the array `NAME` has values.
        """
        infos: dict[str, Any] = {**counts, **{f"_{name}": ~ended for name in counts}}
        if not ended.any():
            return infos
        final_observations = np.full(self.num_envs, None, object)
        observations = self._windows(self._jitted_observe(last_states))
        for slot in np.nonzero(ended)[0]:
            final_observations[slot] = observations[slot]
        infos["final_obs"] = final_observations
        infos["_final_obs"] = ended
        infos["final_info"] = {**counts, **{f"_{name}": ended for name in counts}}
        infos["_final_info"] = ended
        return infos

    def _reset(self, key: Any) -> tuple[Any, Any, Any]:
        """Returns the next key, then observations and states of new episodes."""
        key, resets = jax.random.split(key)
        return key, *jax.vmap(self.env.reset)(jax.random.split(resets, self._shape[0]))

    def _step(self, key: Any, state: Any, actions: Any) -> tuple[Any, Any, Any, Any, Any]:
        """Returns the next key, then observation, state, rewards and infos.

        Rewards and events have an entry for each agent, `[B, N]`.
        """
        key, step_key = jax.random.split(key)
        keys = jax.random.split(step_key, self._shape[0])
        observation, state, reward, _, info = jax.vmap(self.env.step)(keys, state, actions)
        if self._common_reward:
            reward = jnp.broadcast_to(reward.sum(axis=-1, keepdims=True), reward.shape)
        infos = {name: info[name] for name in ("terminated", "truncated", "terminal_state")}
        infos["events"] = {
            name: jnp.broadcast_to(count.reshape(self._shape[0], -1), self._shape)
            for name, count in info["events"].items()
        }
        return key, observation, state, reward, infos

    def _windows(self, observation: Any) -> np.ndarray:
        """Returns `[num_envs, rows, cols, channels]` of `[B, N, channels, rows, cols]`."""
        windows = np.moveaxis(np.asarray(observation), 2, -1)
        return np.ascontiguousarray(windows).reshape(self.num_envs, *windows.shape[2:])


def environment_id(game: str) -> str:
    """Returns the id of a game in Gymnasium's registry: `sjdsl/CleanUp-v0` for `clean_up`."""
    return f"sjdsl/{''.join(word.capitalize() for word in game.split('_'))}-v0"


# `gymnasium.make("sjdsl/CleanUp-v0")` works once this module is imported.
for _name in bundled():
    if environment_id(_name) not in gymnasium.registry:
        gymnasium.register(
            environment_id(_name), "sjdsl.interop.gymnasium_agent:AgentGame", kwargs={"game": _name}
        )

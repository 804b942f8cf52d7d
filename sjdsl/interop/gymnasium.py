"""Gymnasium adapter: a compiled game as a vector environment with one sub-environment an agent, or for one agent."""

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
    """`num_envs` environments of a game; sub-environment (slot) `b * num_agents + i` is agent i of environment b.

    Autoreset happens in the same step: `observations` are those of the new episode, the last ones of the old episode are in
    `infos["final_obs"]`. Rewards are raw, float64. Infos have the events of the step.

    Attributes:
      env: the `sjdsl.Environment`.
    """

    KEPT = ("_key", "_state", "closed", "_np_random", "_np_random_seed")
    metadata = {"autoreset_mode": AutoresetMode.SAME_STEP, "render_modes": []}  # noqa: RUF012, as Gymnasium has it

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
          num_envs: environments of the game; Gymnasium's `num_envs` of the result is this times the number of agents.
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
        self._common_reward, self.closed = common_reward, False
        self._np_random, self._np_random_seed = None, None
        self._key: Any = None
        self._state: Any = None
        self._begin, self._advance = jax.jit(self._reset), jax.jit(self._step)
        self._look = jax.jit(jax.vmap(self.env.observe))
        self._allowed = jax.jit(jax.vmap(self.env.allowed_actions))

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Starts all episodes; without a seed the random draws continue, or start anywhere the first time.

        The same seed, one number, gives the same episodes under the same actions.

        Raises:
          TypeError: the seed isn't one whole number, or there is an option. ValueError: the seed is negative.
        """
        if options:
            raise TypeError(f"there is no option `{next(iter(options))}`")
        super().reset(seed=checked_seed(seed))
        if seed is not None or self._key is None:
            self._key = seeded_key(seed)
        self._key, observation, self._state = self._begin(self._key)
        return self._windows(observation), {}

    def step(
        self, actions: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """Plays one step of every environment.

        Raises:
          RuntimeError: before the first reset, or after `close`.
          TypeError: the actions aren't whole numbers. ValueError: they have another shape, or one is out of range.
        """
        if self.closed:
            raise RuntimeError("the environment is closed")
        if self._state is None:
            raise RuntimeError("call reset before step")
        chosen = np.asarray(actions)
        if chosen.shape != (self.num_envs,):
            raise ValueError(f"expected actions of shape ({self.num_envs},), got {chosen.shape}")
        chosen = numbers_of_actions(
            chosen, self.env.num_actions, lambda slot: f" of slot {slot}"
        ).reshape(self._shape)
        self._key, observation, self._state, reward, info = self._advance(
            self._key, self._state, chosen
        )
        terminated, truncated = (
            np.repeat(info[name], self._shape[1]) for name in ("terminated", "truncated")
        )
        counts = by_name(
            {name: np.asarray(count).reshape(-1) for name, count in info["events"].items()}
        )
        infos = self._infos(counts, terminated | truncated, info["terminal_state"])
        return (
            self._windows(observation),
            np.asarray(reward, np.float64).reshape(-1),
            terminated,
            truncated,
            infos,
        )

    def action_masks(self) -> np.ndarray:
        """Returns which actions each agent may take next, `[num_envs, num_actions]` bool. Raises RuntimeError before the first reset."""
        if self._state is None:
            raise RuntimeError("call reset before action_masks")
        return action_masks(self.env, self._state, self._allowed).reshape(self.num_envs, -1)

    def _infos(
        self, counts: dict[str, np.ndarray], ended: np.ndarray, last_states: Any
    ) -> dict[str, Any]:
        """Returns arrays by name, each with `_name`, where it holds, as Gymnasium's own vector environments have them."""
        going = counts | {f"_{name}": ~ended for name in counts}
        if not ended.any():
            return going
        last = np.full(self.num_envs, None, object)
        observations = self._windows(self._look(last_states))
        for slot in np.nonzero(ended)[0]:
            last[slot] = observations[slot]
        events = counts | {f"_{name}": ended for name in counts}
        return going | {
            "final_obs": last,
            "_final_obs": ended,
            "final_info": events,
            "_final_info": ended,
        }

    def _reset(self, key: Any) -> tuple[Any, Any, Any]:
        key, resets = jax.random.split(key)
        return key, *jax.vmap(self.env.reset)(jax.random.split(resets, self._shape[0]))

    def _step(self, key: Any, state: Any, actions: Any) -> tuple[Any, Any, Any, Any, Any]:
        """Returns rewards and events with an entry for each agent, `[B, N]`."""
        key, steps = jax.random.split(key)
        observation, state, reward, _, info = jax.vmap(self.env.step)(
            jax.random.split(steps, self._shape[0]), state, actions
        )
        if self._common_reward:
            reward = jnp.broadcast_to(reward.sum(axis=-1, keepdims=True), reward.shape)
        events = {
            n: jnp.broadcast_to(c if c.ndim == 2 else c[:, None], self._shape)
            for n, c in info["events"].items()
        }
        kept = {name: info[name] for name in ("terminated", "truncated", "terminal_state")}
        return key, observation, state, reward, {**kept, "events": events}

    def _windows(self, observation: Any) -> np.ndarray:
        """Returns `[num_envs, rows, cols, channels]` of `[B, N, channels, rows, cols]`."""
        last = np.moveaxis(np.asarray(observation), 2, -1)
        return np.ascontiguousarray(last).reshape(self.num_envs, *last.shape[2:])


def environment_id(game: str) -> str:
    """Returns the id of a game in Gymnasium's registry: `sjdsl/CleanUp-v0` for `clean_up`."""
    return f"sjdsl/{''.join(word.capitalize() for word in game.split('_'))}-v0"


for _name in bundled():  # `gymnasium.make("sjdsl/CleanUp-v0")`, once this module is imported
    if environment_id(_name) not in gymnasium.registry:
        gymnasium.register(
            environment_id(_name), "sjdsl.interop.gymnasium_agent:AgentGame", kwargs={"game": _name}
        )

"""Many environments of a game as slots of one agent each, for libraries that know single agents: NumPy arrays in and out."""

from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from sjdsl.factory import make


@dataclass(frozen=True)
class SlotStep:
    """What one step gives, S slots.

    observations: `[S, rows, cols, channels]` uint8, of a new episode where one has ended; rewards: `[S]` float32;
    terminated, truncated: `[S]` bool; events: counts by name, `[S]` int32; final: the last observations of the episodes that
    have ended, by slot.
    """

    observations: np.ndarray
    rewards: np.ndarray
    terminated: np.ndarray
    truncated: np.ndarray
    events: dict[str, np.ndarray]
    final: dict[int, np.ndarray]


class Slots:
    """`num_envs` environments stepped together; slot `b * num_agents + i` is agent i of environment b.

    Attributes:
      env: the `sjdsl.Environment`; num_slots; window: `(rows, cols, channels)` of an observation.
    """

    def __init__(self, game: str, num_envs: int, observation: str = "onehot", common_reward: bool = False, **arguments: Any) -> None:
        """Makes the environments.

        Args:
          game, observation, arguments: of `sjdsl.make`.
          num_envs: how many.
          common_reward: every agent is paid the sum of its environment's rewards.
        Raises:
          ValueError: `num_envs` is less than 1.
        """
        if num_envs < 1:
            raise ValueError(f"num_envs is at least 1, not {num_envs}")
        self.env = make(game, observation=observation, **arguments)
        self.num_envs, self.num_agents = num_envs, self.env.num_agents
        self.num_slots = num_envs * self.num_agents
        _, channels, rows, cols = self.env.observation_shape
        self.window = (rows, cols, channels)
        self._common_reward = common_reward
        self._key: Any = None
        self._state: Any = None
        self._begin = jax.jit(self._reset)
        self._advance = jax.jit(self._step)
        self._look = jax.jit(jax.vmap(self.env.observe))

    def reset(self, seed: int | None = None) -> np.ndarray:
        """Starts all episodes and returns the observations; without a seed the draws go on, or begin somewhere at first."""
        if seed is not None:
            self._key = jax.random.key(seed)
        elif self._key is None:
            self._key = jax.random.key(int(np.random.SeedSequence().generate_state(1)[0]))
        self._key, observation, self._state = self._begin(self._key)
        return self._slots(observation)

    def step(self, actions: np.ndarray) -> SlotStep:
        """Plays one step of every environment.

        Args:
          actions: `[S]` integers.
        Raises:
          RuntimeError: before the first reset. ValueError: another shape, or a number that is no action.
        """
        if self._state is None:
            raise RuntimeError("call reset before step")
        chosen = np.asarray(actions)
        if chosen.shape != (self.num_slots,):
            raise ValueError(f"actions have shape {chosen.shape}, one for each slot is wanted: ({self.num_slots},)")
        wrong = (chosen < 0) | (chosen >= self.env.num_actions)
        if wrong.any():
            raise ValueError(f"{chosen[wrong][0]} is no action of slot {wrong.argmax()}: 0 .. {self.env.num_actions - 1}")
        chosen = chosen.reshape(self.num_envs, self.num_agents).astype(np.int32)
        self._key, observation, self._state, reward, info = self._advance(self._key, self._state, chosen)
        ended = np.asarray(info["terminated"] | info["truncated"])
        spread = lambda values: np.repeat(np.asarray(values), self.num_agents)  # noqa: E731
        return SlotStep(
            observations=self._slots(observation),
            rewards=np.array(reward).reshape(-1),  # a copy: Stable-Baselines3 adds to it
            terminated=spread(info["terminated"]),
            truncated=spread(info["truncated"]),
            events={name: np.asarray(count).reshape(-1) for name, count in info["events"].items()},
            final=self._final(info["terminal_state"], ended),
        )

    def _final(self, states: Any, ended: np.ndarray) -> dict[int, np.ndarray]:
        """Returns the last observations of the environments that have ended; observed only then."""
        if not ended.any():
            return {}
        observations = self._slots(self._look(states))
        return {int(slot): observations[slot] for slot in np.nonzero(np.repeat(ended, self.num_agents))[0]}

    def _reset(self, key: Any) -> tuple[Any, Any, Any]:
        key, resets = jax.random.split(key)
        return key, *jax.vmap(self.env.reset)(jax.random.split(resets, self.num_envs))

    def _step(self, key: Any, state: Any, actions: Any) -> tuple[Any, Any, Any, Any, Any]:
        key, steps = jax.random.split(key)
        observation, state, reward, _, info = jax.vmap(self.env.step)(jax.random.split(steps, self.num_envs), state, actions)
        if self._common_reward:
            reward = jnp.broadcast_to(reward.sum(axis=-1, keepdims=True), reward.shape)
        shape = (self.num_envs, self.num_agents)
        events = {n: jnp.broadcast_to(c if c.ndim == 2 else c[:, None], shape) for n, c in info["events"].items()}
        kept = {name: info[name] for name in ("terminated", "truncated", "terminal_state")}
        return key, observation, state, reward, {**kept, "events": events}

    def _slots(self, observation: Any) -> np.ndarray:
        """Returns `[S, rows, cols, channels]` of `[B, N, channels, rows, cols]`."""
        last = np.moveaxis(np.asarray(observation), 2, -1)
        return np.ascontiguousarray(last).reshape(self.num_slots, *self.window)

"""Many environments as a batch of single agents (slots), with NumPy arrays in and out."""

from dataclasses import dataclass
from typing import Any, Literal

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from sjdsl.interop.calls import action_masks, numbers_of_actions, seeded_key
from sjdsl.interop.copies import Copied
from sjdsl.library.factory import make
from sjdsl.runtime.env import Encoding


@dataclass(frozen=True)
class SlotStep:
    """The results of one step, for S slots.

    observations: `[S, rows, cols, channels]` uint8; rewards: `[S]` float32; terminated, truncated: `[S]` bool; events: counts by
    name, `[S]` int32; began: `[S]` bool, whether the step was the start of an episode instead; final: the last observations of the
    episodes that have ended, by slot, if `observations` no longer has them.
    """

    observations: np.ndarray
    rewards: np.ndarray
    terminated: np.ndarray
    truncated: np.ndarray
    events: dict[str, np.ndarray]
    began: np.ndarray
    final: dict[int, np.ndarray]


Autoreset = Literal["same step", "next step", "never"]


class Slots(Copied):
    """`num_envs` environments stepped together; slot `b * num_agents + i` is agent i of environment b.

    `autoreset` sets when the next episode starts: in the `same step` as the last one ends; in the `next step`, which ignores the actions of
    that environment and has reward 0; or `never`, until `reset` is called for it.

    Attributes:
      env: the `sjdsl.Environment`; num_slots; window: `(rows, cols, channels)` of an observation.
    """

    KEPT = ("_key", "_state", "_over")

    def __init__(
        self,
        game: str,
        num_envs: int,
        observation: Encoding = "onehot",
        common_reward: bool = False,
        autoreset: Autoreset = "same step",
        **arguments: Any,
    ) -> None:
        """Makes the environments.

        Args:
          game, observation, arguments: of `sjdsl.make`.
          num_envs: the number of environments.
          common_reward: whether every agent gets the sum of its environment's rewards.
          autoreset: see above.
        Raises:
          ValueError: `num_envs` is less than 1.
        """
        if num_envs < 1:
            raise ValueError(f"num_envs must be at least 1, not {num_envs}")
        self.env = make(game, observation=observation, **arguments)
        self.num_envs, self.num_agents = num_envs, self.env.num_agents
        self.num_slots = num_envs * self.num_agents
        _, channels, rows, cols = self.env.observation_shape
        self.window = (rows, cols, channels)
        self._common_reward, self._autoreset = common_reward, autoreset
        self._key: Any = None
        self._state: Any = None
        self._over = np.zeros(num_envs, bool)  # whose episode has ended and not restarted
        self._begin = jax.jit(self._reset)
        self._advance = jax.jit(self._step)
        self._advance_alone = jax.jit(self._step_env)
        self._look = jax.jit(jax.vmap(self.env.observe))
        self._allowed = jax.jit(jax.vmap(self.env.allowed_actions))

    def reset(self, seed: int | None = None, chosen: np.ndarray | None = None) -> np.ndarray:
        """Starts episodes and returns the observations of all; without a seed the random draws continue, or start anywhere the first time.

        Args:
          chosen: `[S]` bool, the slots whose environments to reset; all by default, and the first time.
        Raises:
          ValueError: `chosen` has another shape, or only some of the agents of an environment; the seed is negative.
          TypeError: the seed isn't a whole number.
        """
        envs = np.ones(self.num_envs, bool) if chosen is None else self._whole(chosen)
        if self._state is None:
            envs[:] = True
        if seed is not None or self._key is None:
            self._key = seeded_key(seed)
        self._key, observation, state = self._begin(self._key)
        self._over = self._over & ~envs
        if envs.all():
            self._state = state
            return self._slots(observation)
        self._state = jax.tree.map(lambda new, old: _where(envs, new, old), state, self._state)
        return self._slots(self._look(self._state))

    def step(self, actions: np.ndarray) -> SlotStep:
        """Plays one step of every environment.

        Args:
          actions: `[S]` integers.
        Raises:
          RuntimeError: before the first reset, or in an environment that has ended and waits for its reset.
          TypeError: the actions aren't whole numbers. ValueError: they have another shape, or one is out of range.
        """
        if self._state is None:
            raise RuntimeError("call reset before step")
        chosen = np.asarray(actions)
        if chosen.shape != (self.num_slots,):
            raise ValueError(f"expected actions of shape ({self.num_slots},), got {chosen.shape}")
        chosen = numbers_of_actions(chosen, self.env.num_actions, lambda slot: f" of slot {slot}")
        if self._autoreset == "never" and self._over.any():
            raise RuntimeError(f"environment {self._over.argmax()} has ended; reset it before the next step")
        chosen = chosen.reshape(self.num_envs, self.num_agents)
        begins, same = self._over, self._autoreset == "same step"
        if same:
            self._key, observation, self._state, reward, info = self._advance(self._key, self._state, chosen)
        else:
            self._key, observation, self._state, reward, info = self._advance_alone(self._key, self._state, chosen, begins)
        ended = np.asarray(info["terminated"] | info["truncated"])
        if not same:
            self._over = ended

        def spread(values: Any) -> np.ndarray:
            return np.repeat(np.asarray(values), self.num_agents)

        return SlotStep(
            observations=self._slots(observation),
            rewards=np.array(reward).reshape(-1),  # a copy: Stable-Baselines3 adds to it
            terminated=spread(info["terminated"]),
            truncated=spread(info["truncated"]),
            events={name: np.asarray(count).reshape(-1) for name, count in info["events"].items()},
            began=spread(begins),
            final=self._final(info["terminal_state"], ended) if same else {},
        )

    def action_masks(self) -> np.ndarray:
        """Returns which actions each slot may take next, `[S, A]` bool. Raises RuntimeError before the first reset."""
        if self._state is None:
            raise RuntimeError("call reset before action_masks")
        return action_masks(self.env, self._state, self._allowed).reshape(self.num_slots, -1)

    def _whole(self, chosen: np.ndarray) -> np.ndarray:
        """Returns the environments of the chosen slots."""
        mask = np.asarray(chosen, bool)
        if mask.shape != (self.num_slots,):
            raise ValueError(f"expected a mask of shape ({self.num_slots},), got {mask.shape}")
        by_env = mask.reshape(self.num_envs, self.num_agents)
        parted = by_env.any(axis=1) & ~by_env.all(axis=1)
        if parted.any():
            raise ValueError(
                f"the mask has only some agents of environment {parted.argmax()}; reset all or none, as they start an episode together"
            )
        result: np.ndarray = np.all(by_env, axis=1)
        return result

    def _final(self, states: Any, ended: np.ndarray) -> dict[int, np.ndarray]:
        """Returns the last observations of the environments that have ended."""
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
        return key, observation, state, *self._outcome(reward, info)

    def _step_env(self, key: Any, state: Any, actions: Any, begins: Any) -> tuple[Any, Any, Any, Any, Any]:
        """Plays a step of the running environments; those that restart are reset, with rewards and counts 0."""
        key, steps = jax.random.split(key)
        keys = jax.vmap(jax.random.split)(jax.random.split(steps, self.num_envs))
        observation, stepped, reward, _, info = jax.vmap(self.env.step_env)(keys[:, 0], state, actions)

        def with_fresh() -> tuple[Any, Any]:
            fresh = jax.vmap(self.env.reset)(keys[:, 1])
            result: tuple[Any, Any] = jax.tree.map(lambda new, old: _where(begins, new, old), fresh, (observation, stepped))
            return result

        seen, state = jax.lax.cond(begins.any(), with_fresh, lambda: (observation, stepped))
        reward, info = self._outcome(reward, info)

        def quiet(leaf: Array) -> Array:
            result: Array = _where(begins, jnp.zeros_like(leaf), leaf)
            return result

        info = {"events": info["events"], "terminated": info["terminated"], "truncated": info["truncated"]}
        return key, seen, state, quiet(reward), {**jax.tree.map(quiet, info), "terminal_state": state}

    def _outcome(self, reward: Any, info: dict[str, Any]) -> tuple[Any, dict[str, Any]]:
        """Returns rewards and infos with an entry for each agent."""
        if self._common_reward:
            reward = jnp.broadcast_to(reward.sum(axis=-1, keepdims=True), reward.shape)
        shape = (self.num_envs, self.num_agents)
        events = {n: jnp.broadcast_to(c if c.ndim == 2 else c[:, None], shape) for n, c in info["events"].items()}
        kept = {name: info[name] for name in ("terminated", "truncated", "terminal_state")}
        return reward, {**kept, "events": events}

    def _slots(self, observation: Any) -> np.ndarray:
        """Returns `[S, rows, cols, channels]` of `[B, N, channels, rows, cols]`."""
        last = np.moveaxis(np.asarray(observation), 2, -1)
        return np.ascontiguousarray(last).reshape(self.num_slots, *self.window)


def _where(chosen: Any, new: Any, old: Any) -> Any:
    """Returns the leaves `[B, ...]` of the chosen environments from `new`, the others from `old`."""
    return jnp.where(jnp.asarray(chosen).reshape(-1, *[1] * (new.ndim - 1)), new, old)

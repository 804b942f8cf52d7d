"""SocialJax's log wrappers: returns and lengths of episodes in the infos."""

from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
from flax import struct
from jax import Array


@struct.dataclass
class LogState:
    """The state of the environment, and of each agent `[N]` float32: what has come together in this episode, and in the last that ended."""

    env_state: Any
    episode_returns: Array
    episode_original_returns: Array
    episode_lengths: Array
    returned_episode_returns: Array
    returned_episode_original_returns: Array
    returned_episode_lengths: Array


class LogWrapper:
    """Adds to the infos, `[N]` each: `returned_episode_returns`, `returned_episode_lengths` and `returned_episode` (whether one has just ended)."""

    def __init__(self, env: Any, replace_info: bool = False) -> None:
        """`replace_info`: leaves the environment's own infos out."""
        self._env, self._replace_info = env, replace_info

    def __getattr__(self, name: str) -> Any:
        return getattr(self._env, name)

    @partial(jax.jit, static_argnums=(0,))
    def reset(self, key: Array) -> tuple[Array, LogState]:
        """Returns the first observations and state."""
        observation, state = self._env.reset(key)
        return observation, LogState(state, *[jnp.zeros(self._env.num_agents)] * 6)

    @partial(jax.jit, static_argnums=(0,))
    def step(
        self, key: Array, state: LogState, actions: Any, timestep: Any = 0
    ) -> tuple[Array, LogState, Array, dict[str, Any], dict[str, Any]]:
        """As the environment's."""
        observation, inner, reward, done, info = self._env.step(key, state.env_state, actions, timestep)
        over = done["__all__"]
        total = (state.episode_returns + reward, state.episode_original_returns + info["original_rewards"], state.episode_lengths + 1)
        before = (state.returned_episode_returns, state.returned_episode_original_returns, state.returned_episode_lengths)
        state = LogState(
            inner, *(jnp.where(over, 0, x) for x in total), *(jnp.where(over, x, y) for x, y in zip(total, before, strict=True))
        )
        info = {} if self._replace_info else dict(info)
        return (
            observation,
            state,
            reward,
            done,
            info | self._figures(state) | {"returned_episode": jnp.full_like(state.episode_returns, over, bool)},
        )

    def _figures(self, state: LogState) -> dict[str, Array]:
        names = ("returned_episode_returns", "returned_episode_lengths")
        return {name: getattr(state, name) for name in names}


class SVOLogWrapper(LogWrapper):
    """Adds `returned_episode_original_returns` too: of the raw rewards."""

    def _figures(self, state: LogState) -> dict[str, Array]:
        return super()._figures(state) | {"returned_episode_original_returns": state.returned_episode_original_returns}

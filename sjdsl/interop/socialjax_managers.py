"""SocialJax's wrappers for central critics and for joint action values, and its parameter files."""

import math
import os
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
from flax.traverse_util import flatten_dict, unflatten_dict
from jax import Array
from safetensors.flax import load_file, save_file

SEPARATOR = ","  # between the names of nested parameters, as the suite's files have it
Batch = dict[str, Array]


class _Wrapper:
    """Forwards everything that it doesn't define."""

    def __init__(self, env: Any) -> None:
        self._env = env

    def __getattr__(self, name: str) -> Any:
        return getattr(self._env, name)


class MAPPOWorldStateWrapper(_Wrapper):
    """Adds `world_state`; the suite's scripts themselves build the critic's input, all observations side by side."""

    def world_state(self, observation: Array, state: Any) -> Array:
        """Returns the observations of all agents, `[N, …]`."""
        del state
        return jnp.stack([observation[agent] for agent in self._env.agents])


class CTRolloutManager(_Wrapper):
    """`batch_size` environments at once, in dictionaries by "0", "1", …, for algorithms that learn one value of all agents.

    Observations have `"__all__"` too, those of all agents as one vector; rewards have `"__all__"`, their sum over `training_agents`,
    which counts a shared reward once for each agent, as the suite does. Arrays begin with the axis of environments, B.

    Attributes:
      max_action_space: the number of actions; max_obs_length: the size of an observation; obs_size: its size after preprocessing.
    """

    def __init__(self, env: Any, batch_size: int, training_agents: Sequence[int] | None = None, preprocess_obs: bool = True) -> None:
        """Makes the manager.

        Args:
          env: a game, or a game in a log wrapper.
          batch_size: B.
          training_agents: the agents whose rewards are summed; all by default.
          preprocess_obs: whether to flatten observations and append the agent's number in one-hot form.
        """
        super().__init__(env)
        self.batch_size, self.preprocess_obs = batch_size, preprocess_obs
        self.training_agents = list(env.agents) if training_agents is None else list(training_agents)
        space, shape = env.observation_space()
        self.observation_spaces = {str(agent): space for agent in env.agents}
        self.action_spaces = {str(agent): env.action_space(agent) for agent in env.agents}
        self.max_obs_length = math.prod(shape)
        self.max_action_space = env.action_space().n
        self.obs_size = self.max_obs_length + (len(env.agents) if preprocess_obs else 0)

    @partial(jax.jit, static_argnums=0)
    def batch_reset(self, key: Array) -> tuple[Batch, Any]:
        """Returns the first observations and states."""
        observation, states = jax.vmap(self._env.reset)(jax.random.split(key, self.batch_size))
        return self._by_agent(observation), states

    @partial(jax.jit, static_argnums=0)
    def batch_step(self, key: Array, states: Any, actions: Mapping[str, Array]) -> tuple[Batch, Any, Batch, Batch, dict[str, Array]]:
        """Plays one step of every environment. `actions`: `[B]` for each agent, by its name or its number."""
        chosen = [actions[str(agent)] if str(agent) in actions else actions[agent] for agent in self._env.agents]
        keys = jax.random.split(key, self.batch_size)
        observation, states, reward, done, info = jax.vmap(self._env.step)(keys, states, chosen)
        rewards = {str(agent): reward[:, agent] for agent in self._env.agents}
        rewards["__all__"] = sum(reward[:, agent] for agent in self.training_agents)
        return self._by_agent(observation), states, rewards, done, info

    @partial(jax.jit, static_argnums=(0, 2))
    def batch_sample(self, key: Array, agent: int | str) -> Array:
        """Returns a uniformly random action for an agent in every environment, `[B]`."""
        sample = self._env.action_space(agent).sample
        result: Array = jax.vmap(sample)(jax.random.split(key, self.batch_size)).astype(jnp.int32)
        return result

    def get_valid_actions(self, states: Any) -> Batch:
        """Returns ones, `[B, A]` for each agent: every action is valid, as in the suite."""
        del states
        return {str(agent): jnp.ones((self.batch_size, self.max_action_space)) for agent in self._env.agents}

    def _by_agent(self, observation: Array) -> Batch:
        """Returns `[B, N, …]` by agent, and all as one vector."""
        vectors = observation.reshape(*observation.shape[:2], -1)
        made = observation
        if self.preprocess_obs:
            numbers = jnp.broadcast_to(jnp.eye(vectors.shape[1]), (*vectors.shape[:2], vectors.shape[1]))
            made = jnp.concatenate([vectors, numbers], axis=-1)
        return {**{str(agent): made[:, agent] for agent in self._env.agents}, "__all__": vectors.reshape(len(vectors), -1)}


def save_params(params: Mapping[str, Any], filename: str | os.PathLike[str]) -> None:
    """Writes nested parameters as safetensors, names joined by commas, into a file that the suite's own `load_params` reads."""
    Path(filename).parent.mkdir(parents=True, exist_ok=True)
    save_file(flatten_dict(params, sep=SEPARATOR), filename)


def load_params(filename: str | os.PathLike[str]) -> dict[str, Any]:
    """Returns the nested parameters of such a file."""
    result: dict[str, Any] = unflatten_dict(load_file(filename), sep=SEPARATOR)
    return result

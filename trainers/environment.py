"""The protocol of an environment that trainers need.

Compiled games follow it, and so may any other environment.
"""

from collections.abc import Mapping
from typing import Any, Protocol

import jax
import jax.numpy as jnp
from jax import Array

from sjdsl.runtime.planes import TokenPlane


class Environment(Protocol):
    """One environment of N agents, not batched: trainers `vmap` it.

    It may also have `state_vector(state)`, `episode_length`, `num_trials` (then the info of a step
    has `trial`, the number of its trial), `with_params(params)` (the same environment with other
    numbers), and `allowed_actions(state)`: `[N, A]` bool, which actions each
    agent may take. Without the last, or if `forbids_actions` is false, all actions are always
    allowed.
    """

    params: Any  # pytree of the game's numbers; not part of `hash`

    @property
    def hash(self) -> str: ...  # of the compiled game; a stored policy warns when it meets another
    @property
    def name(self) -> str: ...
    @property
    def num_agents(self) -> int: ...
    @property
    def num_actions(self) -> int: ...
    @property
    def action_names(self) -> tuple[str, ...]: ...
    @property
    def token_planes(self) -> tuple[TokenPlane, ...]: ...

    def reset(self, key: Array) -> tuple[Array, Any]:
        """Returns the observation `[N, P, V, V]` uint8 and the state of a new episode."""
        ...

    def step(
        self, key: Array, state: Any, actions: Array
    ) -> tuple[Array, Any, Array, Array, dict[str, Any]]:
        """Plays actions `[N]` int32, and starts a new episode when one ends.

        Returns observation, state, raw reward `[N]` float32, done `[]` bool and info: `truncated`
        `[]` bool, done by the time limit; `terminal_observation`, the one before a new episode;
        `events`, name -> `[N]` or `[]` int32 counts of this step; `metrics`, name -> `[]` float32
        values at the end of the step. In games with trials also `trial_ended` `[]` bool: the next
        step is the first of a trial.
        """
        ...

    def step_env(
        self, key: Array, state: Any, actions: Array
    ) -> tuple[Array, Any, Array, Array, dict[str, Any]]:
        """Plays actions without starting a new episode; `terminal_observation` may be missing."""
        ...


class MaskedEnvironment(Environment, Protocol):
    """An environment that may forbid actions."""

    def allowed_actions(self, state: Any) -> Array:
        """Returns which actions each agent may take: `[N, A]` bool."""
        ...


class ObservableEnvironment(Environment, Protocol):
    """An environment whose whole state a central critic can see.

    `info` of its step also has `terminal_state`, that before a new episode.
    """

    def state_vector(self, state: Any) -> Array:
        """Returns the state as `[K]` float32."""
        ...


def episode_length(env: Environment) -> int:
    """Returns the most steps of an episode; 0 if the environment doesn't say."""
    return int(getattr(env, "episode_length", 0))


def num_trials(env: Environment) -> int:
    """Returns the trials of an episode; 1 if the environment doesn't say."""
    return int(getattr(env, "num_trials", 1))


def reset_shapes(env: Environment) -> tuple[Any, Any]:
    """Returns the shapes and dtypes of an observation and a state."""
    result: tuple[Any, Any] = jax.eval_shape(env.reset, abstract_key())
    return result


def info_shapes(env: Environment) -> dict[str, Any]:
    """Returns the shapes and dtypes of a step's info."""
    actions = jax.ShapeDtypeStruct((env.num_agents,), jnp.int32)
    _, state = reset_shapes(env)
    info: dict[str, Any]
    _, _, _, _, info = jax.eval_shape(env.step, abstract_key(), state, actions)
    return info


def trial_ended(info: Mapping[str, Any]) -> Array:
    """Returns whether a trial ended with a step, `[...]` bool; never in a game without trials."""
    result: Array = jnp.asarray(info.get("trial_ended", jnp.zeros_like(info["truncated"])))
    return result


def abstract_key() -> Any:
    """Returns the shape and dtype of a typed key."""
    return jax.eval_shape(lambda: jax.random.key(0))


def where_env(chosen: Array, new: Any, old: Any) -> Any:
    """Returns the leaves `[B, ...]` of `new` for environments `[B]` that are chosen, else `old`."""

    def of_leaf(new: Array, old: Array) -> Array:
        return jnp.where(chosen.reshape(*chosen.shape, *[1] * (new.ndim - chosen.ndim)), new, old)

    return jax.tree.map(of_leaf, new, old)

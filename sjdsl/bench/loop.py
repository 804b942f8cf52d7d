"""The measured loop: random play of many environments, with the observations of every step written to memory."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
from jax import Array

from sjdsl.bench import yardstick
from sjdsl.bench.devices import on_devices
from sjdsl.runtime.env import Environment

YARDSTICK = "yardstick"


@dataclass(frozen=True)
class Task:
    """Something to be measured: `step(state, actions, key) -> (state, reward, observation)` of one environment.

    `crowd` is the number of agents, if it isn't the game's own.
    """

    name: str
    num_agents: int
    num_actions: int
    reset: Callable[[], Any]
    step: Callable[[Any, Array, Array], tuple[Any, Array, Array]]
    env: Environment | None = None
    crowd: int | None = None

    @property
    def observation(self) -> str:
        return self.env.observation if self.env is not None else "tokens"


def yardstick_task() -> Task:
    """Returns the step written by hand."""
    return Task(
        YARDSTICK, yardstick.NUM_AGENTS, yardstick.NUM_ACTIONS, yardstick.reset, yardstick.step
    )


def game_task(env: Environment, name: str = "", crowd: int | None = None) -> Task:
    """Returns `env.step`, its reset at the end of an episode included."""

    def step(state: Any, actions: Array, key: Array) -> tuple[Any, Array, Array]:
        observation, state, reward, _, _ = env.step(key, state, actions)
        return state, reward, observation

    def reset() -> Any:
        return env.reset(jax.random.key(0))[1]

    return Task(name or env.name, env.num_agents, env.num_actions, reset, step, env, crowd)


def make_loop(
    task: Task, num_envs: int, num_steps: int, devices: int = 1
) -> Callable[[Array], Array]:
    """Returns a function of a key that plays and returns the sum of all rewards and of the last observations.

    Args:
      num_envs: environments in all; each device plays its share of them.
    Raises ValueError if they can't be split evenly over the devices.
    """
    each, left = divmod(num_envs, devices)
    if left:
        raise ValueError(f"{num_envs} environments can't be split evenly over {devices} devices")

    def run(key: Array) -> Array:
        start = jax.tree.map(lambda x: jnp.broadcast_to(x, (each, *x.shape)), task.reset())
        return play(
            jax.vmap(task.step), start, (each, task.num_agents), task.num_actions, num_steps, key
        )

    return run if devices == 1 else on_devices(run, devices)


def play(
    step: Callable[..., Any],
    start: Any,
    shape: tuple[int, int],
    num_actions: int,
    num_steps: int,
    key: Array,
) -> Array:
    """Returns the sum of all rewards and of the last observations of random play.

    Each step's observations are written to memory and carried to the next, as a rollout would keep them. To sum them up in
    each step instead costs more than some of the steps, the more so the more planes there are (docs/performance.md).

    Args:
      step: `(states, actions, keys) -> (states, reward, observation)` of all environments.
      start: the first states.
      shape: how many environments, how many agents.
    """

    def body(
        carry: tuple[Any, Array, Array, Array], nothing: None
    ) -> tuple[tuple[Any, Array, Array, Array], None]:
        state, _, total, key = carry
        state, observation, reward, key = one(state, key)
        return (state, observation, total + reward.sum(), key), nothing

    def one(state: Any, key: Array) -> tuple[Any, Array, Array, Array]:
        key, k_action, k_step = jax.random.split(key, 3)
        action = jax.random.randint(k_action, shape, 0, num_actions)
        state, reward, observation = step(state, action, jax.random.split(k_step, shape[0]))
        return state, observation, reward, key

    seen = jax.eval_shape(one, start, key)[1]
    nothing = jnp.zeros(seen.shape, seen.dtype)
    _, observation, total, _ = jax.lax.scan(
        body, (start, nothing, jnp.float32(0), key), None, num_steps
    )[0]
    result: Array = total + observation.astype(jnp.float32).sum()
    return result


def steps_for(num_envs: int) -> int:
    """Returns how many steps one timing takes: long enough for a clock, short enough to wait for."""
    return max(50, 40_000 // num_envs)

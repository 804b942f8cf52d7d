"""The measured loop: random play of many environments, with the observations of every step written
to memory.
"""

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
    """An environment whose steps are measured."""

    name: str
    num_agents: int
    num_actions: int
    reset: Callable[[], Any]
    # `(state, actions, key) -> (state, reward, observation)` of one environment.
    step: Callable[[Any, Array, Array], tuple[Any, Array, Array]]
    env: Environment | None = None
    crowd: int | None = None  # the number of agents, if it isn't the game's own

    @property
    def observation(self) -> str:
        return self.env.observation if self.env is not None else "tokens"


def yardstick_task() -> Task:
    """Returns the yardstick as a task: a step of Commons Harvest written by hand in JAX, with which
    compiled games are compared."""
    return Task(
        YARDSTICK, yardstick.NUM_AGENTS, yardstick.NUM_ACTIONS, yardstick.reset, yardstick.step
    )


def game_task(env: Environment, name: str = "", crowd: int | None = None) -> Task:
    """Returns the task of `env.step`, with its reset at the end of an episode."""

    def step(state: Any, actions: Array, key: Array) -> tuple[Any, Array, Array]:
        observation, state, reward, _, _ = env.step(key, state, actions)
        return state, reward, observation

    def reset() -> Any:
        _, state = env.reset(jax.random.key(0))
        return state

    return Task(name or env.name, env.num_agents, env.num_actions, reset, step, env, crowd)


def make_loop(
    task: Task, num_envs: int, num_steps: int, devices: int = 1
) -> Callable[[Array], Array]:
    """Returns a function of a key that plays and returns the sum of all rewards and of the last
    observations.

    Args:
      num_envs: environments in all; each device plays its share of them.
    Raises ValueError if they can't be split evenly over the devices.
    """
    share, remainder = divmod(num_envs, devices)
    if remainder:
        raise ValueError(f"{num_envs} environments can't be split evenly over {devices} devices")

    def run(key: Array) -> Array:
        start = jax.tree.map(lambda x: jnp.broadcast_to(x, (share, *x.shape)), task.reset())
        shape = (share, task.num_agents)
        return play(jax.vmap(task.step), start, shape, task.num_actions, num_steps, key)

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

    The observations of each step are written to memory and carried to the next, as a rollout would
    keep them. To sum them up in each step instead costs more than some of the steps, the more so
    the more planes there are (docs/research/performance.md).

    Args:
      step: `(states, actions, keys) -> (states, reward, observation)` of all environments.
      start: the first states.
      shape: the numbers of environments and of agents.
    """

    def random_step(state: Any, key: Array) -> tuple[Any, Array, Array, Array]:
        key, action_key, step_key = jax.random.split(key, 3)
        action = jax.random.randint(action_key, shape, 0, num_actions)
        state, reward, observation = step(state, action, jax.random.split(step_key, shape[0]))
        return state, observation, reward, key

    def body(
        carry: tuple[Any, Array, Array, Array], _input: None
    ) -> tuple[tuple[Any, Array, Array, Array], None]:
        state, _, total, key = carry
        state, observation, reward, key = random_step(state, key)
        return (state, observation, total + reward.sum(), key), None

    _, observation_shape, _, _ = jax.eval_shape(random_step, start, key)
    zeros = jnp.zeros(observation_shape.shape, observation_shape.dtype)
    carry, _ = jax.lax.scan(body, (start, zeros, jnp.float32(0), key), None, num_steps)
    _, observation, total, _ = carry
    result: Array = total + observation.astype(jnp.float32).sum()
    return result


def steps_for(num_envs: int) -> int:
    """Returns the number of steps of one timing: enough for an exact time, few enough to wait
    for.
    """
    return max(50, 40_000 // num_envs)

"""Timings that can be compared: every task is measured in turn, round by round, in one process."""

import os
import platform
import statistics
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import jax
from jax import Array

from sjdsl import __version__
from sjdsl.bench.loop import Task, make_loop, steps_for, yardstick_task
from sjdsl.runtime.env import Environment


@dataclass(frozen=True)
class Speed:
    """Environment steps a second of one task: the median of the rounds, the slowest and the fastest.

    `ratio` is the median over rounds of the task's speed to the yardstick's in the same round.
    """

    name: str
    num_envs: int
    env_steps_per_s: float
    slowest: float
    fastest: float
    ratio: float
    loop_compile_s: float

    @property
    def spread(self) -> float:
        """Half the way from the slowest round to the fastest, as a fraction of the median."""
        return (self.fastest - self.slowest) / 2 / self.env_steps_per_s


@dataclass(frozen=True)
class Compilation:
    """What XLA has to do for one `env.step` under `jit`."""

    name: str
    compile_s: float
    stablehlo_lines: int


@dataclass(frozen=True)
class Report:
    """All figures of one run, and what they were measured on."""

    machine: dict[str, Any]
    observation: str
    repeats: int
    speeds: tuple[Speed, ...]
    compilations: tuple[Compilation, ...]

    def to_json(self) -> dict[str, Any]:
        return asdict(self)


def measure(
    tasks: Sequence[Task],
    num_envs: Sequence[int],
    repeats: int = 5,
    steps: Callable[[int], int] = steps_for,
    tell: Callable[[str], object] = lambda _: None,
) -> Report:
    """Returns the speeds of all tasks and of the yardstick at each number of environments.

    Args:
      tasks: what to measure beside the yardstick.
      num_envs: how many environments play at once; each number is measured apart.
      repeats: rounds; in each every task is timed once.
      steps: number of environments -> steps of one timing.
      tell: called with a line whenever something has begun.
    """
    compilations = []
    for task in tasks:
        if task.env is not None:
            tell(f"compiling one step of {task.name}")
            compilations.append(compile_step(task.env, task.name))
    speeds: list[Speed] = []
    for number in num_envs:
        speeds += _race([yardstick_task(), *tasks], number, steps(number), repeats, tell)
    observation = next((task.env.observation for task in tasks if task.env is not None), "tokens")
    return Report(describe_machine(), observation, repeats, tuple(speeds), tuple(compilations))


def compile_step(env: Environment, name: str = "") -> Compilation:
    """Returns the cost of compiling one step of a single environment, and the size of what XLA is given."""
    key = jax.random.key(0)
    state = jax.eval_shape(env.reset, key)[1]
    actions = jax.ShapeDtypeStruct((env.num_agents,), "int32")
    lowered = env.step.lower(key, state, actions)
    began = time.perf_counter()
    lowered.compile()
    return Compilation(name or env.name, time.perf_counter() - began, len(lowered.as_text().splitlines()))


def _race(tasks: Sequence[Task], num_envs: int, num_steps: int, repeats: int, tell: Callable[[str], None]) -> list[Speed]:
    """Measures all tasks at one number of environments; the first of them is the yardstick."""
    loops, compile_s = [], []
    for task in tasks:
        tell(f"compiling {task.name} for {num_envs} environments")
        began = time.perf_counter()
        loops.append(jax.jit(make_loop(task, num_envs, num_steps)).lower(jax.random.key(0)).compile())
        compile_s.append(time.perf_counter() - began)
        loops[-1](jax.random.key(1)).block_until_ready()
    rates: list[list[float]] = [[] for _ in tasks]
    for number in range(repeats):
        tell(f"{num_envs} environments, round {number + 1} of {repeats}")
        for index, loop in enumerate(loops):
            rates[index].append(num_envs * num_steps / _seconds(loop, jax.random.key(number)))
    speeds = []
    for task, rate, seconds in zip(tasks, rates, compile_s, strict=True):
        ratio = statistics.median(a / b for a, b in zip(rate, rates[0], strict=True))
        speeds.append(Speed(task.name, num_envs, statistics.median(rate), min(rate), max(rate), ratio, seconds))
    return speeds


def _seconds(loop: Callable[[Array], Array], key: Array) -> float:
    began = time.perf_counter()
    loop(key).block_until_ready()
    return time.perf_counter() - began


def describe_machine() -> dict[str, Any]:
    """Returns what the figures depend on besides the games."""
    device = jax.devices()[0]
    return {
        "platform": device.platform,
        "device": device.device_kind,
        "cpu_cores": os.cpu_count(),
        "python": platform.python_version(),
        "jax": jax.__version__,
        "sjdsl": __version__,
    }

"""Timing in rounds: every task is measured in turn, in one process, so that the results can be compared."""

import statistics
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any, NamedTuple

import jax
from jax import Array
from jax.stages import Compiled

from sjdsl.bench.compilation import Compilation, compile_step
from sjdsl.bench.loop import Task, make_loop, steps_for, yardstick_task
from sjdsl.bench.machine import describe_machine, device_peak_bytes
from sjdsl.several import several


@dataclass(frozen=True)
class Speed:
    """Environment steps a second of one task: the median of the rounds, the slowest and the fastest.

    `ratio` is the median over rounds of the task's speed to the yardstick's in the same round. `memory_bytes` is what XLA
    says the whole loop needs: the states, the observations of one step and everything in between. `env_steps_per_processor_s` is the
    median of steps a second of processor time, of all cores together, which other programs hardly change.
    """

    name: str
    num_agents: int
    observation: str
    crowd: int | None
    num_envs: int
    env_steps_per_s: float
    slowest: float
    fastest: float
    ratio: float
    loop_compile_s: float
    memory_bytes: int
    env_steps_per_processor_s: float

    @property
    def spread(self) -> float:
        """Half the way from the slowest round to the fastest, as a fraction of the median."""
        return (self.fastest - self.slowest) / 2 / self.env_steps_per_s


class Round(NamedTuple):
    """What one round took: seconds of the clock, and of all processors together."""

    env_steps: int
    seconds: float
    processor_seconds: float

    @property
    def rate(self) -> float:
        """Environment steps a second."""
        return self.env_steps / self.seconds

    @property
    def rate_of_processor(self) -> float:
        """Environment steps a second of processor time, which has ticks of its own."""
        return self.env_steps / max(
            self.processor_seconds, time.get_clock_info("process_time").resolution
        )


@dataclass(frozen=True)
class Report:
    """All figures of one run, and what they were measured on."""

    machine: dict[str, Any]
    repeats: int
    speeds: tuple[Speed, ...]
    compilations: tuple[Compilation, ...]
    device_peak_bytes: int | None
    left_out: tuple[str, ...] = ()  # what couldn't be measured, and why


def measure(
    tasks: Task | Sequence[Task],
    num_envs: int | Sequence[int],
    repeats: int = 5,
    steps: Callable[[int], int] = steps_for,
    tell: Callable[[str], object] = lambda _: None,
    workers: int = 1,
    devices: int = 1,
) -> Report:
    """Returns the speeds of all tasks and of the yardstick at each number of environments.

    Args:
      tasks: what to measure beside the yardstick.
      num_envs: how many environments play at once; each number is measured apart. Of tasks and numbers one may stand for itself.
      repeats: rounds; in each every task is timed once.
      steps: number of environments -> steps of one timing.
      tell: called with a line whenever something has begun.
      workers: programs compiled at the same time. With more than one, seconds of compiling mean little, and one step of one environment
        isn't compiled.
      devices: over how many the environments are split (`bench.devices`); every number of environments is a multiple of it.
    """
    tasks, num_envs = several(tasks), several(num_envs)
    compilations = []
    for task in tasks if workers == 1 else ():
        if task.env is not None:
            tell(f"compiling one step of {task.name}")
            compilations.append(compile_step(task.env, task.name))
    speeds: list[Speed] = []
    everyone = [yardstick_task(), *tasks]
    for number in num_envs:

        def compile_one(task: Task, number: int = number) -> tuple[Compiled, float]:
            tell(f"compiling {task.name} for {number} environments")
            return compile_loop(task, number, steps(number), devices)

        def announce(round_number: int, number: int = number) -> None:
            tell(f"{number} environments, round {round_number} of {repeats}")

        with ThreadPoolExecutor(workers) as pool:
            compiled = list(pool.map(compile_one, everyone))
        rounds = timed_rounds(
            [loop for loop, _ in compiled],
            [number * steps(number)] * len(compiled),
            repeats,
            announce,
        )
        speeds += [
            speed_of(task, number, own, rounds[0], made)
            for task, own, made in zip(everyone, rounds, compiled, strict=True)
        ]
    return Report(
        describe_machine(devices), repeats, tuple(speeds), tuple(compilations), device_peak_bytes()
    )


def compile_loop(
    task: Task, num_envs: int, num_steps: int, devices: int = 1
) -> tuple[Compiled, float]:
    """Returns the measured loop and the seconds it took to compile."""
    began = time.perf_counter()
    loop = jax.jit(make_loop(task, num_envs, num_steps, devices)).lower(jax.random.key(0)).compile()
    return loop, time.perf_counter() - began


def speed_of(
    task: Task,
    num_envs: int,
    rounds: Sequence[Round],
    yardstick: Sequence[Round],
    compiled: tuple[Compiled, float],
) -> Speed:
    """Returns the speed of a task from its rounds and those of the yardstick."""
    loop, seconds = compiled
    rates = [one.rate for one in rounds]
    ratio = statistics.median(
        own.rate / its.rate for own, its in zip(rounds, yardstick, strict=True)
    )
    figures = (statistics.median(rates), min(rates), max(rates), ratio, seconds, memory_of(loop))
    of_processor = statistics.median(one.rate_of_processor for one in rounds)
    return Speed(
        task.name, task.num_agents, task.observation, task.crowd, num_envs, *figures, of_processor
    )


def race(
    loops: Sequence[Callable[[Array], Array]],
    env_steps: Sequence[int],
    repeats: int,
    tell: Callable[[int], object],
) -> list[list[float]]:
    """Returns environment steps a second by loop and round, as `timed_rounds`."""
    return [
        [one.rate for one in rounds] for rounds in timed_rounds(loops, env_steps, repeats, tell)
    ]


def timed_rounds(
    loops: Sequence[Callable[[Array], Array]],
    env_steps: Sequence[int],
    repeats: int,
    tell: Callable[[int], object],
) -> list[list[Round]]:
    """Returns the times by loop and round: in each round every loop runs once, for `env_steps` steps."""
    for loop in loops:
        loop(jax.random.key(1)).block_until_ready()  # the first call may be slower
    rounds: list[list[Round]] = [[] for _ in loops]
    for number in range(repeats):
        tell(number + 1)
        for own, loop, number_of_steps in zip(rounds, loops, env_steps, strict=True):
            key = jax.random.key(number)
            began = time.perf_counter()
            began_on_processor = time.process_time()
            loop(key).block_until_ready()
            own.append(
                Round(
                    number_of_steps,
                    time.perf_counter() - began,
                    time.process_time() - began_on_processor,
                )
            )
    return rounds


def memory_of(compiled: Compiled) -> int:
    """Returns the bytes XLA needs for a program: arguments, results and everything in between, its code aside."""
    stats = compiled.memory_analysis()
    if stats is None:
        return 0
    result: int = (
        stats.temp_size_in_bytes
        + stats.argument_size_in_bytes
        + stats.output_size_in_bytes
        - stats.alias_size_in_bytes
    )
    return result

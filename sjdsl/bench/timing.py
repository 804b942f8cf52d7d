"""Timing in rounds: every task is measured in turn, in one process, so that the results can be
compared.
"""

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
    """Environment steps a second of one task: the median of the rounds, the slowest and the
    fastest.
    """

    name: str
    num_agents: int
    observation: str
    crowd: int | None
    num_envs: int
    env_steps_per_s: float
    slowest: float
    fastest: float
    # Median over rounds of the task's speed divided by the yardstick's in the same round.
    ratio: float
    loop_compile_s: float
    # Of the whole loop, by XLA: the states, the observations of one step and everything in between.
    memory_bytes: int
    # Median of steps a second of processor time, of all cores together, on which other programs
    # have little effect.
    env_steps_per_processor_s: float

    @property
    def spread(self) -> float:
        """Half the way from the slowest round to the fastest, as a fraction of the median."""
        return (self.fastest - self.slowest) / 2 / self.env_steps_per_s


class Round(NamedTuple):
    """The time of one round: seconds of the clock, and of all processors together."""

    env_steps: int
    seconds: float
    processor_seconds: float

    @property
    def rate(self) -> float:
        """Environment steps a second."""
        return self.env_steps / self.seconds

    @property
    def rate_of_processor(self) -> float:
        """Environment steps a second of processor time, which is at least one tick of its clock."""
        tick = time.get_clock_info("process_time").resolution
        return self.env_steps / max(self.processor_seconds, tick)


@dataclass(frozen=True)
class Report:
    """All figures of one run, and the machine."""

    machine: dict[str, Any]
    repeats: int
    speeds: tuple[Speed, ...]
    compilations: tuple[Compilation, ...]
    device_peak_bytes: int | None
    left_out: tuple[str, ...] = ()  # notes on tasks that couldn't be measured


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
      tasks: one task or several, beside the yardstick.
      num_envs: numbers of environments that play at once, one or several, measured one after
        another.
      repeats: rounds, in each of which every task is timed once.
      steps: number of environments -> steps of one timing.
      tell: called with a line at the start of each compilation and round.
      workers: programs compiled at the same time. With more than one, seconds of compiling mean
        little, and one step of one environment isn't compiled.
      devices: the number of devices over which the environments are split (`bench.devices`), which
        divides every number of environments.
    """
    compilations = []
    for task in several(tasks) if workers == 1 else ():
        if task.env is not None:
            tell(f"compiling one step of {task.name}")
            compilations.append(compile_step(task.env, task.name))
    speeds: list[Speed] = []
    all_tasks = [yardstick_task(), *several(tasks)]
    for number in several(num_envs):
        num_steps = steps(number)

        def compile_task(
            task: Task, number: int = number, num_steps: int = num_steps
        ) -> tuple[Compiled, float]:
            tell(f"compiling {task.name} for {number} environments")
            return compile_timed(make_loop(task, number, num_steps, devices))

        def announce(round_number: int, number: int = number) -> None:
            tell(f"{number} environments, round {round_number} of {repeats}")

        with ThreadPoolExecutor(workers) as pool:
            compiled = list(pool.map(compile_task, all_tasks))
        loops = [loop for loop, _ in compiled]
        env_steps = [number * num_steps] * len(loops)
        rounds = timed_rounds(loops, env_steps, repeats, announce)
        for task, task_rounds, compilation in zip(all_tasks, rounds, compiled, strict=True):
            speeds.append(speed_of(task, number, task_rounds, rounds[0], compilation))
    machine = describe_machine(devices)
    return Report(machine, repeats, tuple(speeds), tuple(compilations), device_peak_bytes())


def compile_timed(loop: Callable[..., Array], *arguments: Any) -> tuple[Compiled, float]:
    """Returns a function of a key and these arguments, compiled, and the seconds that took."""
    start = time.perf_counter()
    program = jax.jit(loop).lower(jax.random.key(0), *arguments).compile()
    return program, time.perf_counter() - start


def speed_of(
    task: Task,
    num_envs: int,
    rounds: Sequence[Round],
    yardstick: Sequence[Round],
    compiled: tuple[Compiled, float],
) -> Speed:
    """Returns the speed of a task from its rounds and those of the yardstick."""
    loop, seconds = compiled
    rates = [round_.rate for round_ in rounds]
    yardstick_rates = [round_.rate for round_ in yardstick]
    ratios = [rate / other for rate, other in zip(rates, yardstick_rates, strict=True)]
    return Speed(
        name=task.name,
        num_agents=task.num_agents,
        observation=task.observation,
        crowd=task.crowd,
        num_envs=num_envs,
        env_steps_per_s=statistics.median(rates),
        slowest=min(rates),
        fastest=max(rates),
        ratio=statistics.median(ratios),
        loop_compile_s=seconds,
        memory_bytes=memory_of(loop),
        env_steps_per_processor_s=statistics.median(round_.rate_of_processor for round_ in rounds),
    )


def race(
    loops: Sequence[Callable[[Array], Array]],
    env_steps: Sequence[int],
    repeats: int,
    tell: Callable[[int], object],
) -> list[list[float]]:
    """Returns environment steps a second by loop and round; see `timed_rounds`."""
    by_loop = timed_rounds(loops, env_steps, repeats, tell)
    return [[round_.rate for round_ in rounds] for rounds in by_loop]


def timed_rounds(
    loops: Sequence[Callable[[Array], Array]],
    env_steps: Sequence[int],
    repeats: int,
    tell: Callable[[int], object],
) -> list[list[Round]]:
    """Returns the times by loop and round: in each round every loop runs once, for `env_steps`
    steps.
    """
    for loop in loops:
        loop(jax.random.key(1)).block_until_ready()  # the first call may be slower
    rounds: list[list[Round]] = [[] for _ in loops]
    for number in range(repeats):
        tell(number + 1)
        for index, loop in enumerate(loops):
            key = jax.random.key(number)
            start = time.perf_counter()
            processor_start = time.process_time()
            loop(key).block_until_ready()
            seconds = time.perf_counter() - start
            processor_seconds = time.process_time() - processor_start
            rounds[index].append(Round(env_steps[index], seconds, processor_seconds))
    return rounds


def median_seconds(function: Callable[[], Array], repeats: int) -> float:
    """Returns the median of the seconds that a function takes, after a first call."""
    function().block_until_ready()
    seconds = []
    for _ in range(repeats):
        start = time.perf_counter()
        function().block_until_ready()
        seconds.append(time.perf_counter() - start)
    return statistics.median(seconds)


def memory_of(compiled: Compiled) -> int:
    """Returns the bytes that XLA needs for a program: arguments, results and everything in between,
    but not the code."""
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

"""The speed of Melting Pot's substrates, one after the other: a row is handed over as soon as it is measured."""

import statistics
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass

import jax
from jax.stages import Compiled

from sjdsl.bench.compilation import compile_step
from sjdsl.bench.loop import Task, game_task, make_loop, yardstick_task
from sjdsl.bench.machine import describe_machine, device_peak_bytes
from sjdsl.bench.timing import Report, Speed, memory_of, race
from sjdsl.factory import make
from sjdsl.substrates import Substrate


@dataclass(frozen=True)
class Substrates(Report):
    """The figures of substrates; there is no row of the yardstick, which takes part in every race."""


def substrate_tasks(entries: Iterable[Substrate]) -> Iterator[Task]:
    """Yields what is measured of each substrate, under the substrate's name; a game is compiled when its turn comes."""
    for entry in entries:
        yield game_task(make(entry.game, variant=entry.variant or None), entry.name)


def short_steps(num_envs: int) -> int:
    """Returns how many steps one timing takes: a fifth of what a single game has, as there are so many of them."""
    return max(20, 8000 // num_envs)


def measure_substrates(
    tasks: Iterable[Task],
    num_envs: Sequence[int],
    repeats: int,
    keep: Callable[[Substrates], object],
    steps: Callable[[int], int] = short_steps,
    tell: Callable[[str], object] = lambda _: None,
) -> Substrates:
    """Returns the speeds of all tasks; each races against the yardstick alone, so that the ratio is of the same seconds.

    Args:
      tasks: taken one after the other.
      num_envs: how many environments play at once; each number is measured apart.
      repeats: rounds of each race.
      keep: called after every task with all that has been measured, so that a run that is stopped leaves it behind.
      steps: number of environments -> steps of one timing.
      tell: called with a line whenever something has begun.
    """
    tell("compiling the yardstick")
    rulers = {number: _loop(yardstick_task(), number, steps(number))[0] for number in num_envs}
    found = Substrates(describe_machine(), repeats, (), (), None)
    for task in tasks:
        assert task.env is not None
        tell(f"compiling one step of {task.name}")
        step = compile_step(task.env, task.name, repeats=1)
        speeds = []
        for number in num_envs:
            tell(f"{task.name}, {number} environments")
            speeds.append(_speed(task, number, steps(number), repeats, rulers[number]))
        found = Substrates(found.machine, repeats, (*found.speeds, *speeds), (*found.compilations, step), device_peak_bytes())
        keep(found)
    return found


def _loop(task: Task, num_envs: int, num_steps: int) -> tuple[Compiled, float]:
    """Returns the measured loop and the seconds it took to compile."""
    began = time.perf_counter()
    loop = jax.jit(make_loop(task, num_envs, num_steps)).lower(jax.random.key(0)).compile()
    return loop, time.perf_counter() - began


def _speed(task: Task, num_envs: int, num_steps: int, repeats: int, ruler: Compiled) -> Speed:
    """Returns the speed of a task in a race against the yardstick."""
    loop, seconds = _loop(task, num_envs, num_steps)
    ruled, rates = race((ruler, loop), [num_envs * num_steps] * 2, repeats, lambda _: None)
    ratio = statistics.median(ours / its for ours, its in zip(rates, ruled, strict=True))
    figures = (statistics.median(rates), min(rates), max(rates), ratio, seconds, memory_of(loop))
    return Speed(task.name, task.num_agents, task.observation, None, num_envs, *figures)

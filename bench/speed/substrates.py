"""The speed of Melting Pot's substrates, one after the other; each row is reported as soon as it is measured."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass

from sjdsl.bench.compilation import compile_step
from sjdsl.bench.loop import Task, game_task, yardstick_task
from sjdsl.bench.machine import describe_machine, device_peak_bytes
from sjdsl.bench.timing import Report, compile_loop, race, speed_of
from sjdsl.library.factory import make
from sjdsl.library.substrates import Substrate


@dataclass(frozen=True)
class Substrates(Report):
    """The figures of substrates. The yardstick takes part in every race but has no row."""


def substrate_tasks(entries: Iterable[Substrate]) -> Iterator[Task]:
    """Yields what is measured of each substrate, under the substrate's name; a game is compiled when its turn comes."""
    for entry in entries:
        yield game_task(make(entry.game, variant=entry.variant or None), entry.name)


def short_steps(num_envs: int) -> int:
    """Returns the number of steps in one timing: a fifth of that of a single game, as there are many substrates."""
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
    yardsticks = {number: compile_loop(yardstick_task(), number, steps(number))[0] for number in num_envs}
    found = Substrates(describe_machine(), repeats, (), (), None)
    for task in tasks:
        assert task.env is not None
        tell(f"compiling one step of {task.name}")
        step = compile_step(task.env, task.name, repeats=1)
        speeds = []
        for number in num_envs:
            tell(f"{task.name}, {number} environments")
            compiled = compile_loop(task, number, steps(number))
            yardstick, rates = race((yardsticks[number], compiled[0]), [number * steps(number)] * 2, repeats, lambda _: None)
            speeds.append(speed_of(task, number, rates, yardstick, compiled))
        found = Substrates(found.machine, repeats, (*found.speeds, *speeds), (*found.compilations, step), device_peak_bytes())
        keep(found)
    return found

"""The speed of Melting Pot's substrates, one after the other; figures are reported as soon as they are measured."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass

from sjdsl.bench.loop import YARDSTICK, Task, game_task
from sjdsl.bench.machine import describe_machine
from sjdsl.bench.timing import Report, measure
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
      num_envs, repeats, steps, tell: as of `measure`.
      keep: called after every task with all that has been measured, so that a run that is stopped leaves it behind.
    """
    found = Substrates(describe_machine(), repeats, (), (), None)
    for task in tasks:
        own = measure([task], num_envs, repeats, steps, tell)
        speeds = (*found.speeds, *(speed for speed in own.speeds if speed.name != YARDSTICK))
        found = Substrates(
            own.machine,
            repeats,
            speeds,
            (*found.compilations, *own.compilations),
            own.device_peak_bytes,
        )
        keep(found)
    return found

"""The speed of Melting Pot's substrates, one after the other; figures are reported as soon as they
are measured."""

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
    """Yields the task of each substrate, under the substrate's name; compiles each game in its
    turn.
    """
    for entry in entries:
        yield game_task(make(entry.game, variant=entry.variant or None), entry.name)


def short_steps(num_envs: int) -> int:
    """Returns the number of steps in one timing: a fifth of that of a single game, as there are
    many substrates.
    """
    return max(20, 8000 // num_envs)


def measure_substrates(
    tasks: Iterable[Task],
    num_envs: Sequence[int],
    repeats: int,
    keep: Callable[[Substrates], object],
    steps: Callable[[int], int] = short_steps,
    tell: Callable[[str], object] = lambda _: None,
) -> Substrates:
    """Returns the speeds of all tasks; each is measured with the yardstick alone, so that the ratio
    is of the same seconds.

    Args:
      tasks: measured one after the other.
      num_envs, repeats, steps, tell: as of `measure`.
      keep: called with all figures so far after every task, so that nothing is lost if the run
        stops.
    """
    total = Substrates(describe_machine(), repeats, (), (), None)
    for task in tasks:
        report = measure([task], num_envs, repeats, steps, tell)
        speeds = [speed for speed in report.speeds if speed.name != YARDSTICK]
        total = Substrates(
            report.machine,
            repeats,
            (*total.speeds, *speeds),
            (*total.compilations, *report.compilations),
            report.device_peak_bytes,
        )
        keep(total)
    return total

"""Reports the progress of a run: a live bar on a terminal, plain lines elsewhere."""

import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, nullcontext
from typing import Literal, Protocol, get_args

from rich.console import Console, Group
from rich.live import Live
from rich.progress import Progress
from rich.text import Text

from .learning_signs import FIGURES
from .metrics_files import Row

ProgressStyle = Literal["auto", "bar", "lines", "none"]
SECONDS_BETWEEN_LINES = 5.0
COMPILING = "compiling"
NO_EPISODE = "no episode has ended yet"


class Show(Protocol):
    """Shows people the row of an update, and warnings."""

    def __call__(self, row: Row, warnings: Sequence[str] = ()) -> None: ...


@contextmanager
def show_progress(
    style: ProgressStyle, num_updates: int, title: str, seeds: int = 1, steps_before: int = 0
) -> Iterator[Show]:
    """Yields a function that shows the row of each update and warnings.

    Until the first update, it is shown that the run is being compiled. A bar has the latest figures
    below it; lines are printed every few seconds, and at the first update and the last.

    Args:
      seeds: of the run, whose steps are added up.
      steps_before: environment steps of each seed in stages before this one.
    """
    if style not in get_args(ProgressStyle):
        raise ValueError(f"progress must be auto, bar, lines or none, not {style!r}")
    console = Console()
    has_bar = style == "bar" or (style == "auto" and console.is_terminal)
    bar = Progress(console=console)
    task = bar.add_task(title, total=num_updates)
    below = Text(COMPILING)
    outcome = NO_EPISODE
    printed = 0.0

    def show(row: Row, warnings: Sequence[str] = ()) -> None:
        """Shows warnings at once; moves the bar, or prints a line if it is time for one."""
        nonlocal printed, outcome
        for warning in warnings:
            print(f"warning: {warning}", flush=True)
        outcome = _outcome(row) or outcome
        update = row["update"]
        left = row["seconds"] / update * (num_updates - update)
        playing = round(100 * row["rollout_share"])
        line = (
            f"update {update:>{len(str(num_updates))}}/{num_updates}  {row['env_steps']:>11,} steps  "
            f"{rate(row, seeds, steps_before):>9,.0f} steps/s  "
            f"acting {playing} % of the time, learning {100 - playing} %  "
            f"{left:>4.0f} s left  {outcome}{_learning(row)}"
        )
        now = time.monotonic()
        if has_bar:
            bar.update(task, completed=update)
            below.plain = line
        elif now - printed >= SECONDS_BETWEEN_LINES or update in (1, num_updates):
            printed = now
            print(line, flush=True)

    if style == "none":
        yield lambda *_: None
        return
    if not has_bar:
        print(f"{title}: {COMPILING}", flush=True)
    with Live(Group(bar, below), console=console) if has_bar else nullcontext():
        yield show


def rate(row: Row, seeds: int, steps_before: int) -> float:
    """Returns environment steps a second of all seeds in this stage so far, everything included."""
    return float((row["env_steps"] - steps_before) * seeds / row["seconds"])


def _outcome(row: Row) -> str:
    """Returns what the episodes that ended in an update earned, or "" if none ended."""
    if not row["episodes"] > 0:
        return ""
    return (
        f"collective return {row['collective_return']:.1f} "
        f"(before learning {row['before_learning']:.1f})"
    )


def _learning(row: Row) -> str:
    """Returns the figures that say whether a network learns, each after a comma."""
    return "".join(f", {label} {row[name]:.3g}" for name, label in FIGURES.items() if name in row)

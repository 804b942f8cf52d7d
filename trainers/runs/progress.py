"""Reports the progress of a run: a live bar on a terminal, plain lines elsewhere."""

import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Literal, Protocol

from rich.console import Console, Group
from rich.live import Live
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)
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

    Until the first update, it is shown that the run is being compiled.

    Args:
      seeds: of the run, whose steps are added up.
      steps_before: environment steps of each seed in stages before this one.
    """
    if style == "auto":
        style = "bar" if Console().is_terminal else "lines"
    match style:
        case "bar":
            with _bar(num_updates, title, seeds, steps_before) as show:
                yield show
        case "lines":
            print(f"{title}: {COMPILING}", flush=True)
            yield _lines(num_updates, seeds, steps_before)
        case "none":
            yield lambda *_: None
        case _:
            raise ValueError(f"progress must be auto, bar, lines or none, not {style!r}")


@contextmanager
def _bar(num_updates: int, title: str, seeds: int, steps_before: int) -> Iterator[Show]:
    """Shows a bar, and below it what agents earn and how they learn.

    One line would be too long for most terminals.
    """
    progress = Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TextColumn("{task.fields[speed]}"),
        TimeRemainingColumn(compact=True),
    )
    below = Text(COMPILING)
    task = progress.add_task(title, total=num_updates, speed="")
    outcome = NO_EPISODE

    def show(row: Row, warnings: Sequence[str] = ()) -> None:
        """Moves the bar, and prints warnings above it."""
        nonlocal outcome
        for warning in warnings:
            progress.console.print(f"warning: {warning}", markup=False, highlight=False)
        outcome = _outcome(row) or outcome
        speed = f"{rate(row, seeds, steps_before):,.0f} steps/s"
        progress.update(task, completed=row["update"], speed=speed)
        below.plain = f"{outcome}{_learning(row)}, {_share(row)}"

    with Live(Group(progress, below), console=progress.console):
        yield show


def _lines(num_updates: int, seeds: int, steps_before: int) -> Show:
    """Returns a function that prints a line every few seconds, at the first update and the last."""
    digits = len(str(num_updates))
    outcome = NO_EPISODE
    printed = 0.0

    def show(row: Row, warnings: Sequence[str] = ()) -> None:
        """Prints warnings at once, and a line if it is time for one."""
        nonlocal printed, outcome
        for warning in warnings:
            print(f"warning: {warning}", flush=True)
        outcome = _outcome(row) or outcome
        update = row["update"]
        now = time.monotonic()
        if now - printed < SECONDS_BETWEEN_LINES and update not in (1, num_updates):
            return
        printed = now
        left = row["seconds"] / update * (num_updates - update)
        print(
            f"update {update:>{digits}}/{num_updates}  {row['env_steps']:>11,} steps  "
            f"{rate(row, seeds, steps_before):>9,.0f} steps/s  {_share(row)}  "
            f"{left:>4.0f} s left  {outcome}{_learning(row)}",
            flush=True,
        )

    return show


def rate(row: Row, seeds: int, steps_before: int) -> float:
    """Returns environment steps a second of all seeds in this stage so far, everything included."""
    return float((row["env_steps"] - steps_before) * seeds / row["seconds"])


def _share(row: Row) -> str:
    """Returns how an update's time was spent: on acting and environments, and on learning."""
    playing = round(100 * row["rollout_share"])
    return f"acting {playing} % of the time, learning {100 - playing} %"


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

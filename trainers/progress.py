"""How a run reports its progress: a live bar on a terminal, plain lines elsewhere."""

import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Literal

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from .run_folder import Row

ProgressStyle = Literal["auto", "bar", "lines", "none"]
SECONDS_BETWEEN_LINES = 5.0


@contextmanager
def show_progress(style: ProgressStyle, num_updates: int, title: str) -> Iterator[Callable[[Row], None]]:
    """Yields a function that shows the row of each update."""
    if style == "auto":
        style = "bar" if Console().is_terminal else "lines"
    match style:
        case "bar":
            with _bar(num_updates, title) as show:
                yield show
        case "lines":
            yield _lines(num_updates)
        case "none":
            yield lambda row: None
        case _:
            raise ValueError(f"progress must be auto, bar, lines or none, not {style!r}")


@contextmanager
def _bar(num_updates: int, title: str) -> Iterator[Callable[[Row], None]]:
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("{task.fields[speed]}"),
        TimeRemainingColumn(compact=True),
        TextColumn("{task.fields[outcome]}"),
    )
    recent = _RecentReturn()
    with Progress(*columns) as display:
        task = display.add_task(title, total=num_updates, speed="", outcome="")

        def show(row: Row) -> None:
            speed = f"{row['steps_per_second']:,.0f} steps/s"
            display.update(task, completed=row["update"], speed=speed, outcome=recent.read(row))

        yield show


def _lines(num_updates: int) -> Callable[[Row], None]:
    recent = _RecentReturn()
    printed = 0.0

    def show(row: Row) -> None:
        nonlocal printed
        outcome = recent.read(row)
        now = time.monotonic()
        if now - printed < SECONDS_BETWEEN_LINES and row["update"] not in (1, num_updates):
            return
        printed = now
        left = row["seconds"] / row["update"] * (num_updates - row["update"])
        print(
            f"update {row['update']:>{len(str(num_updates))}}/{num_updates}  {row['env_steps']:>11,} steps  "
            f"{row['steps_per_second']:>9,.0f} steps/s  {left:>4.0f} s left  {outcome}",
            flush=True,
        )

    return show


class _RecentReturn:
    """The collective return of the last update in which an episode finished."""

    def __init__(self) -> None:
        self.value = math.nan

    def read(self, row: Row) -> str:
        if row["episodes"] > 0:
            self.value = row["collective_return"]
        return "no episode finished yet" if math.isnan(self.value) else f"collective return {self.value:.1f}"

"""Shows the current stage of a slow command: with elapsed seconds on a terminal, as plain lines
elsewhere.
"""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial

from rich.console import Console
from rich.progress import Progress, SpinnerColumn, TaskID, TextColumn, TimeElapsedColumn

Say = Callable[[str], None]
LOADING = "loading JAX and the game"


@contextmanager
def stages(first: str) -> Iterator[Say]:
    """Shows the current stage on standard error until the block ends.

    Yields a function that announces the next stage. On a terminal, one line shows the stage and its
    time so far, and vanishes at the end. Elsewhere each stage is a line.
    """
    console = Console(stderr=True)
    if not console.is_terminal:
        say = partial(console.print, highlight=False, markup=False, soft_wrap=True)
        say(first)
        yield say
        return
    columns = (
        SpinnerColumn("line"),
        TextColumn("{task.description}", markup=False),
        TimeElapsedColumn(),
    )
    with Progress(*columns, console=console, transient=True) as display:
        task = display.add_task(first, total=None)
        yield lambda stage: display.reset(task, description=stage, total=None)


class StatusLine:
    """A line at the foot of a terminal that shows a command's progress; nothing elsewhere."""

    def __init__(self, display: Progress | None, task: TaskID, about: str):
        self._display = display
        self._task = task
        self._about = about

    def show(self, progress: str) -> None:
        """Shows the command's progress."""
        if self._display is not None:
            self._display.update(self._task, description=f"{self._about}: {progress}")

    @contextmanager
    def hidden(self) -> Iterator[None]:
        """Hides the line while something is printed."""
        if self._display is not None:
            self._display.stop()
        yield
        sys.stdout.flush()
        if self._display is not None:
            self._display.start()


@contextmanager
def status_line(about: str) -> Iterator[StatusLine]:
    """Shows what a command is doing on standard error until the block ends.

    Yields the line that shows the progress. If standard error isn't a terminal, nothing does.
    """
    console = Console(stderr=True)
    if not console.is_terminal:
        console.print(about, highlight=False, markup=False, soft_wrap=True)
        yield StatusLine(None, TaskID(0), about)
        return
    columns = (
        SpinnerColumn("line"),
        TextColumn("{task.description}", markup=False),
        TimeElapsedColumn(),
    )
    with Progress(
        *columns, console=console, transient=True, redirect_stdout=False, redirect_stderr=False
    ) as display:
        yield StatusLine(display, display.add_task(about, total=None), about)

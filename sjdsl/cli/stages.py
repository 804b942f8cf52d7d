"""Shows the current stage of a slow command: with elapsed seconds on a terminal, as plain lines elsewhere."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

Say = Callable[[str], None]
LOADING = "loading JAX and the game"


@contextmanager
def stages(first: str) -> Iterator[Say]:
    """Says what is being done, on the standard error, until the block ends; yields a function that says what comes next.

    On a terminal one line shows the stage and how long it has taken, and vanishes at the end. Elsewhere each stage is a line.
    """
    console = Console(stderr=True)
    if not console.is_terminal:
        console.print(first, highlight=False, markup=False, soft_wrap=True)

        def say(what: str) -> None:
            console.print(what, highlight=False, markup=False, soft_wrap=True)

        yield say
        return
    columns = (SpinnerColumn(), TextColumn("{task.description}", markup=False), TimeElapsedColumn())
    with Progress(*columns, console=console, transient=True) as display:
        task = display.add_task(first, total=None)

        def show(what: str) -> None:
            display.reset(task, description=what, total=None)

        yield show

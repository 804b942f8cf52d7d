"""Where the figures of `sjdsl bench` go: the screen, a file, a page."""

import json
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import click
import jax
from rich import box
from rich.console import Console
from rich.table import Table as RichTable

from sjdsl.bench import Report, Sweep, Training
from sjdsl.bench.machine import machine_line
from sjdsl.bench.markdown import markdown_section, replace_section, write_section
from sjdsl.bench.tables import Table


@contextmanager
def telling() -> Iterator[Callable[[str], object]]:
    """Gives a function that shows in one line what is being done, nothing where nobody watches."""
    console = Console(stderr=True)
    if not console.is_terminal:
        yield lambda _: None
        return
    with console.status("compiling") as status:
        yield status.update


def print_tables(tables: Sequence[Table], machine: dict[str, Any], notes: Sequence[str]) -> None:
    """Prints the tables, as wide as they are where lines are not cut, then the notes and the machine."""
    console = Console()
    console = console if console.is_terminal else Console(width=200)
    for table in tables:
        shown = RichTable(box=box.SIMPLE, title_justify="left", title=table.title)
        for index, heading in enumerate(table.headings):
            shown.add_column(heading, justify="left" if index < table.labels else "right", no_wrap=index == 0)
        for row in table.rows:
            shown.add_row(*row)
        console.print(shown)
    for line in (*notes, machine_line(machine)):
        console.print(line, highlight=False, markup=False)


def write_json(path: Path, found: Report | Sweep | Training) -> None:
    """Writes all figures to a file."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(found.to_json(), indent=2) + "\n", encoding="utf-8")


def section_name(what: str) -> str:
    """Returns the marks between which figures of this sort of machine stand on a page: `speed cpu`, `sweep coins spawn cpu`."""
    return f"{what} {jax.devices()[0].platform}"


def require_marks(page: Path, section: str) -> None:
    """Raises ClickException where the page has no such section: before anything is measured, not an hour later."""
    if not page.is_file():
        return
    try:
        replace_section(page.read_text(encoding="utf-8"), section, "")
    except ValueError as error:
        raise click.ClickException(f"{page}: {error}") from None


def write_page(
    page: Path, section: str, command: str, machine: dict[str, Any], notes: Sequence[str], tables: Sequence[Table], pictures: Sequence[Path]
) -> None:
    """Writes a section of the page: the command, the machine, notes, tables, and pictures as seen from the page."""
    seen = [Path(os.path.relpath(picture, page.parent)).as_posix() for picture in pictures]
    write_section(page, section, markdown_section(command, machine_line(machine), notes, tables, seen))

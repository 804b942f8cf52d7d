"""Writes the figures of `sjdsl bench`: to the screen, to a file, to a page."""

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import click
from rich import box
from rich.console import Console
from rich.table import Table as RichTable

from sjdsl.bench import Report
from sjdsl.bench.machine import machine_line
from sjdsl.bench.markdown import markdown_section, new_page, replace_section, write_section
from sjdsl.bench.plots import draw_scaling
from sjdsl.bench.tables import Table, notes_of, tables_of
from sjdsl.cli.bench_everything import Stored


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


class Outputs(NamedTuple):
    """Where tables go besides the screen: a page, and a folder of plots."""

    page: str | None
    plots: str | None

    def check(self, *sections: str) -> None:
        """Makes a new page with marks for the sections. Raises ClickException where a page that is there lacks some.

        Before anything is measured, not an hour later.
        """
        page = Path(self.page) if self.page else None
        if page is None:
            return
        if not page.is_file():
            new_page(page, sections)
        for section in sections:
            try:
                replace_section(page.read_text(encoding="utf-8"), section, "")
            except ValueError as error:
                raise click.ClickException(f"{page}: {error}") from None

    def show(self, figures: Stored) -> None:
        """Prints the tables, draws the plots where there are speeds, and writes the section of the page."""
        found = figures.found
        print_tables(tables_of(found), found.machine, [*figures.notes, *notes_of(found)])
        self.write(figures)

    def write(self, figures: Stored) -> None:
        """Draws the plots where there are speeds, and writes the section of the page."""
        found = figures.found
        tables, notes = tables_of(found), [*figures.notes, *notes_of(found)]
        pictures = draw_scaling(found, Path(self.plots)) if isinstance(found, Report) and self.plots else ()
        if self.page is None:
            return
        page = Path(self.page)
        seen = [Path(os.path.relpath(picture, page.parent)).as_posix() for picture in pictures]
        text = markdown_section(figures.command, machine_line(found.machine), notes, tables, seen)
        write_section(page, figures.section, text)

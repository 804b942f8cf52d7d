"""Prepares JAX for benchmarks, and prints the figures."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from rich import box
from rich.console import Console
from rich.table import Table as RichTable

if TYPE_CHECKING:
    from sjdsl.bench.tables import Table


def compile_everything_anew() -> None:
    """Has JAX keep and find no programs: seconds of compiling are measured, too."""
    import jax
    from jax.experimental.compilation_cache import compilation_cache

    jax.config.update("jax_enable_compilation_cache", False)
    compilation_cache.reset_cache()  # JAX decides at the first program of a process, which may be made by an import


def print_tables(tables: "Sequence[Table]", machine: dict[str, Any], notes: Sequence[str]) -> None:
    """Prints the tables, as wide as they are where lines are not cut, then the notes and the machine."""
    from sjdsl.bench.machine import machine_line

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

"""Replaces tables on a Markdown page between two marks, and leaves the rest unchanged."""

import re
from collections.abc import Iterable
from pathlib import Path

from sjdsl.bench.tables import Table
from sjdsl.files import write_whole


def markdown_section(
    command: str, machine: str, notes: Iterable[str], tables: Iterable[Table]
) -> str:
    """Returns the figures of one run as Markdown: the command, the machine, notes, tables."""
    parts = [f"`{command}`, on {machine}.", *(f"{note}." for note in notes)]
    for table in tables:
        parts.append(f"{table.title[0].upper()}{table.title[1:]}:")
        parts.append(markdown_table(table))
    return "\n\n".join(parts) + "\n"


def markdown_table(table: Table) -> str:
    """Returns the table; figures are aligned to the right."""
    rule = ("---",) * table.labels + ("--:",) * (len(table.headings) - table.labels)
    return "\n".join(f"| {' | '.join(row)} |" for row in (table.headings, rule, *table.rows))


def replace_section(page: str, name: str, text: str) -> str:
    """Returns the page with the text between the marks `<!-- name -->` and `<!-- end name -->`
    replaced.

    Raises ValueError if the page has no such marks.
    """
    start = f"<!-- {name} -->\n"
    end = f"<!-- end {name} -->"
    section = re.compile(f"({re.escape(start)}).*?({re.escape(end)})", re.DOTALL)
    if not section.search(page):
        raise ValueError(f"the page has no lines `{start.strip()}` and `{end}` to write between")
    return section.sub(lambda match: f"{match[1]}{text}{match[2]}", page, count=1)


def write_section(path: Path, name: str, text: str) -> None:
    """Writes the text between the marks of a page. Raises ValueError if the page has no such
    marks.
    """
    write_whole(path, replace_section(path.read_text(encoding="utf-8"), name, text))

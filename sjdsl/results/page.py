"""A page of results as Markdown: sections with tables and pictures; and the files that go with
it.
"""

import csv
import io
import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from sjdsl.experiments.pictures import picture_bytes
from sjdsl.results.figures import Figure, Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Drawing

FIGURES = "figures"
TABLES = "tables"
ENDINGS = ("png", "svg")


@dataclass(frozen=True)
class Picture:
    """A picture, drawn only when it is written."""

    name: str
    title: str
    draw: Callable[[], "Drawing"]


@dataclass(frozen=True)
class Section:
    """A section of a page. text: paragraphs."""

    title: str
    text: tuple[str, ...] = ()
    tables: tuple[Table, ...] = ()
    pictures: tuple[Picture, ...] = ()


def page_text(
    title: str, sections: Iterable[Section], method: Sequence[str], notes: Sequence[str]
) -> str:
    """Returns the page: its heading, its sections, the method (paragraphs), and notes (a list)."""
    parts = [f"# {title}"]
    for section in sections:
        parts += [f"## {section.title}", body_text(section)]
    parts += ["## Method", *method]
    if notes:
        parts += ["## Notes", "\n".join(f"* {inert(_sentence(note))}" for note in notes)]
    return "\n\n".join(parts) + "\n"


def body_text(section: Section, folder: str = "") -> str:
    """Returns a section without its title.

    Args:
      folder: of its pictures and tables, relative to the page: empty, or ending in `/`.
    """
    parts = [inert(paragraph) for paragraph in section.text]
    for table in section.tables:
        parts += [f"{table.title} ([CSV]({folder}{TABLES}/{table.name}.csv)):", _table_text(table)]
    parts += [
        f"![{inert(picture.title)}]({folder}{FIGURES}/{picture.name}.png)"
        for picture in section.pictures
    ]
    return "\n\n".join(parts)


def _table_text(table: Table) -> str:
    """Returns a table as Markdown."""
    rule = ("---",) * table.labels + ("--:",) * (len(table.headings) - table.labels)
    lines = [table.headings, rule]
    for row in table.rows:
        texts = (cell.text if isinstance(cell, Figure) else cell for cell in row)
        lines.append(tuple(map(_escaped, texts)))
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def file_texts(sections: Iterable[Section]) -> dict[str, str]:
    """Returns the CSV of each table by file name."""
    return {
        f"{TABLES}/{table.name}.csv": _csv(table.records)
        for section in sections
        for table in section.tables
    }


def draw_pictures(sections: Iterable[Section]) -> dict[str, bytes]:
    """Returns each picture as PNG and SVG by file name."""
    files: dict[str, bytes] = {}
    for section in sections:
        for picture in section.pictures:
            drawing = picture.draw()
            for ending in ENDINGS:
                files[f"{FIGURES}/{picture.name}.{ending}"] = picture_bytes(drawing, ending)
    return files


def _csv(records: Sequence[dict[str, Any]]) -> str:
    """Returns rows by column as CSV: a column that a row lacks is empty there."""
    text = io.StringIO()
    names = list(dict.fromkeys(name for record in records for name in record))
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(names)
    for record in records:
        values = [record.get(name) for name in names]
        writer.writerow([f"{value:.6g}" if isinstance(value, float) else value for value in values])
    return text.getvalue()


def _escaped(cell: str) -> str:
    """Returns a cell's text for Markdown, on one line and with `|` escaped."""
    return " ".join(inert(cell).splitlines()).replace("|", "\\|")


def inert(text: str) -> str:
    """Escapes HTML tags: names and contents of folders may come from anybody."""
    return re.sub(r"<(?=[a-zA-Z/!?])", "&lt;", text)


def _sentence(note: str) -> str:
    """Returns a note as a sentence, capitalised unless it begins with something like a path."""
    if note[:1].isalpha() and " " in note:
        return f"{note[0].upper()}{note[1:]}."
    return f"{note}."

"""A report as Markdown: sections with their tables, pictures and commands; and the CSV of each table."""

import csv
import io
import re
from collections.abc import Sequence
from typing import Any

from sjdsl.bench.markdown import markdown_table
from sjdsl.bench.tables import Table as TextTable
from sjdsl.report.page import Section, Table

FIGURES, TABLES = "figures", "tables"


def page_text(title: str, opening: Sequence[str], sections: Sequence[str], notes: Sequence[str]) -> str:
    """Returns the page: its heading and what made it, the texts of its sections, how they are to be read, and notes."""
    made, *method = opening
    parts = [f"# {title}", made, *sections, "## Method", *method]
    if notes:
        parts += ["## Notes", "\n".join(f"* {inert(_sentence(note))}" for note in notes)]
    return "\n\n".join(parts) + "\n"


def section_text(section: Section, folder: str) -> str:
    """Returns a section. `folder`: where its pictures and tables are, as seen from the page: empty, or with a `/` at its end."""
    parts = [f"## {section.title}", *([f"<!-- made of {section.stamp} -->"] if section.stamp else []), *map(inert, section.text)]
    for table in section.tables:
        if table.rows:
            parts.append(f"{table.title} ([CSV]({folder}{TABLES}/{table.name}.csv)):")
            parts.append(
                markdown_table(TextTable(table.title, table.headings, tuple(tuple(map(_escaped, row)) for row in table.rows), table.labels))
            )
        else:
            parts.append(f"[CSV]({folder}{TABLES}/{table.name}.csv)")
    parts += [f"![{inert(picture.title)}]({folder}{FIGURES}/{picture.name}.png)" for picture in section.pictures]
    if section.fill:
        missing = "What is empty is found by:" if section.tables or section.pictures else "Nothing is known of it yet. It is found by:"
        parts += [missing, "```\n" + "\n".join(section.fill) + "\n```"]
    return "\n\n".join(parts)


def earlier_section(page: str, section: Section) -> str | None:
    """Returns the text of a section of an earlier page that was made of the same; None where there is none."""
    found = re.search(rf"^## {re.escape(section.title)}\n.*?(?=^## |\Z)", page, re.MULTILINE | re.DOTALL)
    return found[0].rstrip("\n") if found and section.stamp and f"<!-- made of {section.stamp} -->" in found[0] else None


def table_csv(table: Table) -> str:
    """Returns the records of a table as CSV: figures in six digits, nothing where there is none."""
    text = io.StringIO()
    names = list(dict.fromkeys(name for record in table.records for name in record))
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(names)
    writer.writerows([_plain(record.get(name)) for name in names] for record in table.records)
    return text.getvalue()


def _plain(value: Any) -> Any:
    if isinstance(value, bool) or value is None:
        return {True: "yes", False: "no", None: ""}[value]
    return f"{value:.6g}" if isinstance(value, float) else value


def _escaped(cell: str) -> str:
    return " ".join(inert(cell).splitlines()).replace("|", "\\|")


def inert(text: str) -> str:
    """Returns text in which nothing begins an element of HTML: names of folders, and what stands in their files, come from anybody."""
    return re.sub(r"<(?=[a-zA-Z/!?])", "&lt;", text)


def _sentence(note: str) -> str:
    """Returns a note as a sentence; one that begins with a name keeps it."""
    return f"{note[0].upper()}{note[1:]}." if note[:1].isalpha() and " " in note else f"{note}."

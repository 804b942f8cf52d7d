"""Small pieces of Markdown: names, lists, numbers, tables."""

import math
import re
from collections.abc import Callable, Iterable, Sequence
from decimal import Decimal
from itertools import compress
from typing import Any

from sjdsl.compiler import ir
from sjdsl.compiler.ir.entity_types import IndexSet
from sjdsl.compiler.ir.printer import number_text

Mark = Callable[[str], str]  # such as `code`; `str` leaves a word as it is
SMALLEST = 1e-9  # smaller numbers are written with an exponent


def code(text: str) -> str:
    """Returns text of the game's file as Markdown code."""
    return f"`` {text} ``" if "`" in text else f"`{text}`"


def plain(text: str) -> str:
    """Returns an author's text with all signs of Markdown escaped but code between backticks."""
    parts = re.split(r"(`[^`|\\\n]+`)", text)
    parts[::2] = [re.sub(r"([\\`*_<>\[\]|])", r"\\\1", part) for part in parts[::2]]
    return "".join(parts)


def joined(items: Iterable[str], word: str = "and") -> str:
    """Returns `a, b and c`."""
    *first, last = list(items)
    return f"{', '.join(first)} {word} {last}" if first else last


def number(value: float) -> str:
    """Returns the shortest text that reads back as a number; `any number` for infinity."""
    if math.isinf(value):
        return "any number"
    text = number_text(value)
    return format(Decimal(text), "f") if abs(value) >= SMALLEST else text


def counted(value: float, noun: str) -> str:
    """Returns `1 step`, `3 steps`."""
    return f"{number(value)} {noun}{'' if value == 1 else 's'}"


def table_value(value: Any, by: Sequence[IndexSet], mark: Mark = code) -> str:
    """Returns a value; of an indexed one, each entry: `raw: 3, cut: 1`. mark: makes words code."""
    if not by:
        return mark(value) if isinstance(value, str) else number(value)
    index = by[0]
    entries = [table_value(entry, by[1:], mark) for entry in value]
    if len(by) > 1:
        entries = [f"({entry})" for entry in entries]
    if index.kind != "word" and len(set(entries)) == 1:
        return f"{entries[0]} for each {'agent' if index.kind == 'agent' else f'of {index}'}"
    names = map(mark, index.names) if index.kind == "word" else index.names
    return ", ".join(f"{name}: {entry}" for name, entry in zip(names, entries, strict=True))


def value_at_start(start: float | str | None, field: ir.VarField, mark: Mark = code) -> str:
    """Returns what a field is at first. mark: makes words code."""
    if start is None:
        return {"agents": "empty", "cell": "nowhere"}.get(field.type.kind, "nobody")
    return table_value(start, (), mark)


def fenced(lines: Sequence[str], language: str = "text") -> list[str]:
    """Returns lines between fences that none of them can close."""
    fence = "```"
    while any(fence in line for line in lines):
        fence += "`"
    return [f"{fence}{language}", *lines, fence]


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    """Returns a Markdown table without empty columns; no lines without rows."""
    cells = [list(map(_cell, row)) for row in rows]
    if not cells:
        return []
    is_filled = [any(column) for column in zip(*cells, strict=True)]
    lines = (head, ["---"] * len(head), *cells)
    return [f"| {' | '.join(compress(line, is_filled))} |" for line in lines]


def _cell(text: str) -> str:
    """Returns text for a cell of a table: bars are escaped unless they are already."""
    return text if "\\|" in text else text.replace("|", "\\|")

"""Small pieces of Markdown: names, lists, numbers, tables."""

import math
import re
from collections.abc import Iterable, Sequence
from decimal import Decimal
from itertools import compress
from typing import Any

from sjdsl.compiler.ir.printer import number_text
from sjdsl.compiler.ir.sorts import Level

SMALLEST = 1e-9  # what is smaller is written with an exponent


def code(text: str) -> str:
    """Returns a name of the game's file as it is spelt there."""
    fence = "``" if "`" in text else "`"
    inside = f" {text} " if "`" in text else text
    return f"{fence}{inside}{fence}"


def plain(text: str) -> str:
    """Returns text of an author so that no sign of it means anything to Markdown."""
    return re.sub(r"([\\`*_<>\[\]|])", r"\\\1", text)


def joined(items: Iterable[str], word: str = "and") -> str:
    """Returns `a, b and c`."""
    *first, last = list(items)
    return f"{', '.join(first)} {word} {last}" if first else last


def number(value: float) -> str:
    """Returns a number as short as it can be read back; endless ones in words."""
    if math.isinf(value):
        return "any number"
    return (
        format(Decimal(number_text(value)), "f") if abs(value) >= SMALLEST else number_text(value)
    )


def counted(value: float, noun: str) -> str:
    """Returns `1 step`, `3 steps`."""
    return f"{number(value)} {noun}{'' if value == 1 else 's'}"


def table_value(value: Any, by: Sequence[Level]) -> str:
    """Returns the value of a number or a table by words: `raw: 3, cut: 1`; `raw: (raw: 1, cut: 0), cut: (...)`."""
    if not by:
        return code(value) if isinstance(value, str) else number(value)
    inner = [table_value(v, by[1:]) for v in value]
    shown = [f"({v})" if len(by) > 1 else v for v in inner]
    level = by[0]
    if level.sort != "word" and len(set(shown)) == 1:
        return f"{shown[0]} for each {'agent' if level.sort == 'agent' else f'of {level}'}"
    names = map(code, level.names) if level.sort == "word" else level.names
    return ", ".join(f"{name}: {v}" for name, v in zip(names, shown, strict=True))


def fenced(lines: Sequence[str], language: str = "text") -> list[str]:
    """Returns lines as they are, between fences that none of them can close."""
    longest = max((len(run) for line in lines for run in re.findall(r"`+", line)), default=0)
    fence = "`" * max(3, longest + 1)
    return [f"{fence}{language}", *lines, fence]


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    """Returns a Markdown table, without the columns that say nothing of any row; nothing without rows."""
    cells = [
        [cell.replace("|", "\\|") if "\\|" not in cell else cell for cell in row] for row in rows
    ]
    if not cells:
        return []
    said = [any(column) for column in zip(*cells, strict=True)]
    return [
        "| " + " | ".join(compress(row, said)) + " |" for row in (head, ["---"] * len(head), *cells)
    ]

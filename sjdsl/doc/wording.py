"""Small pieces of Markdown prose: names, lists, numbers, nested lines."""

import math
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from decimal import Decimal
from typing import Any

from sjdsl.compiler.ir.printer import number_text
from sjdsl.compiler.ir.sorts import Level

SMALLEST = 1e-9  # what is smaller is written with an exponent
WIDEST = 220  # characters of a sentence that still takes the sentence inside it onto its own line


@dataclass(frozen=True)
class Line:
    """A sentence, and the sentences it holds for. It begins with a small letter where it is written after a colon."""

    text: str
    inside: tuple["Line", ...] = ()


def code(text: str) -> str:
    """Returns a name of the game's file as it is spelt there."""
    fence = "``" if "`" in text else "`"
    inside = f" {text} " if "`" in text else text
    return f"{fence}{inside}{fence}"


def variable(name: str) -> str:
    """Returns a name that a sentence has given to an agent, a cell or a value."""
    return f"*{name}*"


def plain(text: str) -> str:
    """Returns text of an author so that no sign of it means anything to Markdown."""
    return re.sub(r"([\\`*_<>\[\]|])", r"\\\1", text)


def joined(items: Iterable[str], word: str = "and") -> str:
    """Returns `a, b and c`."""
    *first, last = list(items)
    return f"{', '.join(first)} {word} {last}" if first else last


def codes(names: Iterable[str], word: str = "and") -> str:
    return joined(map(code, names), word)


def number(value: float) -> str:
    """Returns a number as short as it can be read back; endless ones in words."""
    if math.isinf(value):
        return "any number"
    return format(Decimal(number_text(value)), "f") if abs(value) >= SMALLEST else number_text(value)


def counted(value: float, noun: str) -> str:
    """Returns `1 step`, `3 steps`."""
    return f"{number(value)} {noun}{'' if value == 1 else 's'}"


def article(noun: str) -> str:
    """Returns `a wall cell`, `an ore cell`."""
    return f"{'an' if noun[0] in 'aeiou' else 'a'} {noun}"


def capital(text: str) -> str:
    return text[:1].upper() + text[1:]


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


def entries_text(level: Level) -> str:
    """Returns what a row has an entry for: `for each of `raw` and `cut``, `for each agent`, `for each of 0 to 4`."""
    match level.sort:
        case "agent":
            return "for each agent"
        case "number":
            return f"for each of {level.names[0]} to {level.names[-1]}"
        case _:
            return f"for each of {codes(level.names)}"


def bullets(lines: Iterable[Line], depth: int = 0) -> Iterator[str]:
    """Yields sentences as a nested list; a short sentence that is alone inside another stands behind it on its line."""
    for line in lines:
        line = _shortened(line)
        yield f"{'  ' * depth}- {capital(line.text)}{':' if line.inside else '.'}"
        yield from bullets(line.inside, depth + 1)


def _shortened(line: Line) -> Line:
    if len(line.inside) == 1:
        inner = _shortened(line.inside[0])
        if not inner.inside and len(line.text) + len(inner.text) < WIDEST:
            return Line(f"{line.text}: {inner.text}")
    return line


def fenced(lines: Sequence[str]) -> list[str]:
    """Returns lines as they are, between fences that none of them can close."""
    longest = max((len(run) for line in lines for run in re.findall(r"`+", line)), default=0)
    fence = "`" * max(3, longest + 1)
    return [f"{fence}text", *lines, fence]


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    """Returns a Markdown table; nothing without rows."""
    cells = [[cell.replace("|", "\\|") if "\\|" not in cell else cell for cell in row] for row in rows]
    if not cells:
        return []
    return ["| " + " | ".join(row) + " |" for row in (head, ["---"] * len(head), *cells)]

"""Source texts and spans: the file, and the part of it, that a node or a message is about."""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from sjdsl.compiler.diagnostics.frozen import Record


class Span(Record):
    """A half-open part `start .. end` of one file, in characters.

    line, column: of its start, from 1.
    """

    file: str
    start: int
    end: int
    line: int
    column: int


@dataclass(frozen=True)
class Source:
    """One file as read.

    name: what messages call it. folder: where its maps and bases are looked up. file: where the
    text was read, links followed; None for a text of no file. over: returns the text that stands
    in place of a file, or None; an editor has some files open.
    """

    name: str
    text: str
    folder: Path | None = field(default=None, compare=False)
    over: Callable[[Path], str | None] | None = field(default=None, compare=False, repr=False)
    file: Path | None = field(default=None, compare=False, repr=False)

    def instead_of(self, path: Path) -> str | None:
        """Returns the text that stands in place of a file, None for a file that is to be read."""
        return None if self.over is None else self.over(path.resolve())

    def span(self, start: int, end: int) -> Span:
        """Returns the span of the characters `start .. end`."""
        line = self.text.count("\n", 0, start) + 1
        column = start - (self.text.rfind("\n", 0, start) + 1) + 1
        return Span(self.name, start, end, line, column)

    def line(self, number: int) -> str:
        """Returns line `number` (from 1) without its end, empty past the last line."""
        lines = self.text.split("\n")
        return lines[number - 1].rstrip("\r") if 0 < number <= len(lines) else ""

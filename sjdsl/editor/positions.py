"""Positions of the Language Server Protocol: lines and code units of one text, back to its characters, and where these are after an edit."""

import re
from bisect import bisect_right
from collections.abc import Iterable

from lsprotocol import types

from sjdsl.compiler.diagnostics.source import Span

LINE_END = re.compile(r"\r\n|\n|\r")
WIDTHS = {
    "utf-8": (1, 2, 3, 4),
    "utf-16": (1, 1, 1, 2),
    "utf-32": (1, 1, 1, 1),
}  # code units of a character below each of LIMITS
LIMITS = (0x80, 0x800, 0x10000)
UTF16 = "utf-16"


class Lines:
    """The lines of one text. A position is a line and code units in it, both from 0; an offset counts characters of the text from 0.

    What lies outside is moved to the nearest place inside: behind the end of a line, that end; inside a character, its beginning.
    """

    def __init__(self, text: str, encoding: str = UTF16):
        """`encoding`: `utf-8`, `utf-16` or `utf-32`, the code units that the client counts. Raises KeyError for another one."""
        self.text = text
        self._widths = WIDTHS[encoding]
        ends = list(LINE_END.finditer(text))
        self.starts = [0, *(end.end() for end in ends)]
        self._stops = [*(end.start() for end in ends), len(text)]

    def offset(self, position: types.Position) -> int:
        """Returns the character at a position."""
        if position.line >= len(self.starts):
            return len(self.text)
        wanted, stop = position.character, self._stops[position.line]
        for at in range(self.starts[position.line], stop):
            wanted -= self._width(self.text[at])
            if wanted < 0:
                return at
        return stop

    def position(self, offset: int) -> types.Position:
        """Returns the position of a character; a place inside `\\r\\n` is the end of the line."""
        offset = min(max(offset, 0), len(self.text))
        line = bisect_right(self.starts, offset) - 1
        start, offset = self.starts[line], min(offset, self._stops[line])
        return types.Position(line, sum(map(self._width, self.text[start:offset])))

    def range(self, start: int, end: int) -> types.Range:
        """Returns the range of the characters `start .. end`."""
        return types.Range(self.position(start), self.position(end))

    def span(self, span: Span) -> types.Range:
        """Returns the range of a span of this text."""
        return self.range(span.start, span.end)

    def _width(self, character: str) -> int:
        return self._widths[bisect_right(LIMITS, ord(character))]


class Moved:
    """One change between two texts, the part in which they differ: what stands in front of it stays, what stands behind it moves along."""

    def __init__(self, before: str, after: str):
        most = min(len(before), len(after))
        self._front = _alike(before, after)
        self._behind = len(before) - min(
            _alike(reversed(before), reversed(after)), most - self._front
        )
        self._by = len(after) - len(before)

    def start(self, at: int) -> int:
        """Returns where what begins at a character begins now; of what was changed itself, where the change begins."""
        return at + self._by if at >= self._behind else min(at, self._front)

    def end(self, at: int) -> int:
        """Returns where what ends at a character ends now; of what was changed itself, where the change begins."""
        return at if at <= self._front else self.start(at)

    def back(self, at: int) -> int:
        """Returns where a character of the new text was before; one that is new, where the change begins."""
        if at <= self._front:
            return at
        return at - self._by if at - self._by >= self._behind else self._front


def _alike(a: Iterable[str], b: Iterable[str]) -> int:
    """Returns how many characters are the same before the first that differ."""
    count = 0
    for x, y in zip(a, b, strict=False):
        if x != y:
            break
        count += 1
    return count

"""Positions of the Language Server Protocol, characters of a text, and where an edit moves them."""

import re
from bisect import bisect_right
from collections.abc import Iterable
from itertools import takewhile

from lsprotocol import types

from sjdsl.compiler.diagnostics.source import Span

LINE_END = re.compile(r"\r\n|\n|\r")
LIMITS = (0x80, 0x800, 0x10000)
# Code units of a character below each of LIMITS, and from the last on.
WIDTHS = {"utf-8": (1, 2, 3, 4), "utf-16": (1, 1, 1, 2), "utf-32": (1, 1, 1, 1)}
UTF16 = "utf-16"


class Lines:
    """The lines of one text.

    A position is a line and a number of code units in it, an offset a number of characters of the
    text; all count from 0. What lies outside is moved to the nearest place inside: a position
    behind the end of a line to that end, one inside a character to its beginning.
    """

    def __init__(self, text: str, encoding: str = UTF16):
        """Prepares the lines of a text.

        Args:
          encoding: `utf-8`, `utf-16` or `utf-32`, whose code units the client counts.

        Raises:
          KeyError: for another encoding.
        """
        self.text = text
        self._widths = WIDTHS[encoding]
        ends = list(LINE_END.finditer(text))
        self.starts = [0, *(end.end() for end in ends)]
        self._stops = [*(end.start() for end in ends), len(text)]

    def offset(self, position: types.Position) -> int:
        """Returns the offset of the character at a position."""
        if position.line >= len(self.starts):
            return len(self.text)
        stop = self._stops[position.line]
        units = position.character
        for offset in range(self.starts[position.line], stop):
            units -= self._width(self.text[offset])
            if units < 0:
                return offset
        return stop

    def position(self, offset: int) -> types.Position:
        """Returns the position of a character; inside `\\r\\n` it is the end of the line."""
        offset = min(max(offset, 0), len(self.text))
        line = bisect_right(self.starts, offset) - 1
        before = self.text[self.starts[line] : min(offset, self._stops[line])]
        return types.Position(line, sum(map(self._width, before)))

    def range(self, start: int, end: int) -> types.Range:
        """Returns the range of the characters `start .. end`."""
        return types.Range(self.position(start), self.position(end))

    def span(self, span: Span) -> types.Range:
        """Returns the range of a span of this text."""
        return self.range(span.start, span.end)

    def _width(self, character: str) -> int:
        """Returns the number of code units of a character."""
        return self._widths[bisect_right(LIMITS, ord(character))]


class Moved:
    """How offsets move from one text to a later one, which differs in one part.

    What stands before that part stays, what stands behind it moves along.
    """

    def __init__(self, before: str, after: str):
        self._first = _common_length(before, after)
        at_end = _common_length(reversed(before), reversed(after))
        at_most = min(len(before), len(after)) - self._first
        self._behind = len(before) - min(at_end, at_most)
        self._shift = len(after) - len(before)

    def start(self, offset: int) -> int:
        """Returns where what began at an offset begins now.

        What changed itself begins where the change does.
        """
        return offset + self._shift if offset >= self._behind else min(offset, self._first)

    def end(self, offset: int) -> int:
        """Returns where what ended at an offset ends now.

        What changed itself ends where the change begins.
        """
        return offset if offset <= self._first else self.start(offset)

    def back(self, offset: int) -> int:
        """Returns where a character was before; for a new one, where the change begins."""
        if offset <= self._first:
            return offset
        earlier = offset - self._shift
        return earlier if earlier >= self._behind else self._first


def _common_length(first: Iterable[str], second: Iterable[str]) -> int:
    """Returns how many characters two texts have in common at their beginning."""
    pairs = zip(first, second, strict=False)  # up to the end of the shorter one
    same = takewhile(lambda pair: pair[0] == pair[1], pairs)
    return sum(1 for _ in same)

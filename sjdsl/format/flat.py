"""Formats tokens on one line: the spaces between them, their width, and whether they may share a line."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import accumulate

from lark import Token

from sjdsl.format.gaps import Gap
from sjdsl.format.lines import WIDTH
from sjdsl.format.structure import Structure

BETWEEN_ITEMS = 2  # spaces between statements, or rows of a picture, on one line


@dataclass
class Flat:
    """spaces: before each token. ends: column behind each token if all were one line. broken: whether a line ends before it.

    places: tokens before which a line end stays where the author put it. commented: whether comments stand before a token.
    columns: more spaces before some tokens, so that they stand in columns; no part measured here counts them.
    """

    words: list[str]
    spaces: list[int]
    ends: list[int]
    broken: list[bool]
    places: set[int | None]
    commented: list[bool]
    breaks_before: list[int]
    columns: dict[int, int] = field(default_factory=dict)

    def width(self, start: int, end: int) -> int:
        """Returns the columns of the tokens `start .. end`, without the space before them."""
        return self.ends[end] - self.ends[start] + len(self.words[start])

    def text(self, start: int, end: int) -> str:
        """Returns the tokens `start .. end` with the spaces before each."""
        numbers = range(start, end + 1)
        return "".join(" " * (self.spaces[n] + self.columns.get(n, 0)) + self.words[n] for n in numbers)

    def breaks(self, start: int, end: int) -> bool:
        """Returns whether a line end stays before any of the tokens `start .. end`."""
        return self.breaks_before[end + 1] > self.breaks_before[start]

    def fits(self, start: int, end: int, column: int) -> bool:
        """Returns whether the tokens can stand on one line from a column on."""
        return column + self.width(start, end) <= WIDTH and not self.breaks(start + 1, end)


def make_flat(tokens: Sequence[Token], structure: Structure, gaps: Sequence[Gap]) -> Flat:
    """Returns the tokens with what is known of each. Line ends stay where comments are and where items or branches begin."""
    words = [str(token) for token in tokens]
    items = {item: c.sort for c in structure.containers.values() for item in c.items[c.close is None :]}
    firsts = {c.open + 1 for c in structure.containers.values()}
    spaces = [0 if n in structure.tight else 1 for n in range(len(words))]
    for item, sort in items.items():
        spaces[item] = BETWEEN_ITEMS if sort in ("block", "rows") and item not in firsts else 1
    places = {structure.game, *items, *structure.branches, *(c.close for c in structure.containers.values())}
    commented = [bool(gap.comments) for gap in gaps[:-1]]
    broken = [commented[n] or (gap.ended and n in places) for n, gap in enumerate(gaps[:-1])]
    broken[words.index("{", structure.game) + 1] = True  # the game's block is never on one line
    return Flat(
        words=words,
        spaces=spaces,
        ends=list(accumulate(space + len(word) for space, word in zip(spaces, words, strict=True))),
        broken=broken,
        places=places,
        commented=commented,
        breaks_before=[0, *accumulate(broken)],
    )

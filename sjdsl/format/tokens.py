"""The tokens of a text, with what stands between them, their widths and their columns."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import accumulate

from lark import Token

from sjdsl.format.lines import WIDTH
from sjdsl.format.structure import Structure

BETWEEN_ITEMS = 2  # spaces between statements, or rows of a picture, on one line
Range = tuple[int, int]


@dataclass(frozen=True)
class Comment:
    """A comment.

    trailing: whether it stands on the line of the token before; blank: whether it follows a blank
    line.
    """

    text: str
    trailing: bool = False
    blank: bool = False


@dataclass(frozen=True)
class Gap:
    """What stands before a token.

    ended: whether there is a line end; blank: whether a blank line stands right before the token.
    """

    comments: tuple[Comment, ...] = ()
    ended: bool = False
    blank: bool = False


def read_gaps(text: str, tokens: Sequence[Token]) -> list[Gap]:
    """Returns the gap before each token and, last, the one behind them all.

    A comment before `{` or `,` is moved behind it, so that these end the line they belong to.
    """
    starts = [*(token.start_pos or 0 for token in tokens), len(text)]
    ends = [0, *(token.end_pos or 0 for token in tokens)]
    gaps = [
        _read_gap(text[end:start], first=end == 0) for end, start in zip(ends, starts, strict=True)
    ]
    for number, token in enumerate(tokens):
        gap = gaps[number]
        if token.type in ("LBRACE", "COMMA") and gap.comments:
            behind = gaps[number + 1]
            others = (replace(comment, trailing=False) for comment in behind.comments)
            gaps[number] = Gap()
            gaps[number + 1] = Gap((*gap.comments, *others), True, behind.blank)
        elif token.type == "RBRACE":
            gaps[number] = replace(gap, blank=False)
    return gaps


def _read_gap(text: str, first: bool) -> Gap:
    """Returns the gap with a text. `first`: whether it stands before all tokens."""
    *lines, last = text.split("\n")
    lines_with_comments = [*lines, last] if "#" in last else lines
    comments: list[Comment] = []
    blank = False
    for number, line in enumerate(lines_with_comments):
        comment = line.strip()
        if comment:
            comments.append(Comment(comment, trailing=number == 0 and not first, blank=blank))
        blank = not comment and number > 0
    return Gap(tuple(comments), bool(lines), blank)


class Tokens:
    """The tokens of a text, by their index.

    words: their texts; spaces: before each.
    places: tokens before which a line end of the author stays: items, branches, closing braces.
    broken: whether a line ends before each, because of a comment or of such a line end.
    ends: the column behind each if all stood on one line.
    columns: more spaces before some tokens, which align them; `width` and `fits` don't count these.
    """

    def __init__(self, tokens: Sequence[Token], structure: Structure, gaps: Sequence[Gap]) -> None:
        self.structure = structure
        self.gaps = gaps
        self.words = [str(token) for token in tokens]
        self.spaces = [0 if n in structure.tight else 1 for n in range(len(self.words))]
        self.places = {structure.game, *structure.branches}
        for container in structure.containers.values():
            is_wide = container.content in ("block", "rows")
            items = container.items if container.content != "texts" else container.items[1:]
            for item in items:
                is_first = item == container.open + 1
                self.spaces[item] = BETWEEN_ITEMS if is_wide and not is_first else 1
                self.places.add(item)
            if container.close is not None:
                self.places.add(container.close)
        self.broken = [
            bool(gap.comments) or (gap.ended and n in self.places)
            for n, gap in enumerate(gaps[:-1])
        ]
        first_in_game = self.words.index("{", structure.game) + 1
        self.broken[first_in_game] = True  # a game is never on one line
        self.breaks_before = [0, *accumulate(self.broken)]
        widths = (space + len(word) for space, word in zip(self.spaces, self.words, strict=True))
        self.ends = list(accumulate(widths))
        self.columns: dict[int, int] = {}

    def width(self, start: int, end: int) -> int:
        """Returns the columns of the tokens `start .. end`, without the space before them."""
        return self.ends[end] - self.ends[start] + len(self.words[start])

    def text(self, start: int, end: int) -> str:
        """Returns the tokens `start .. end` with the spaces before each."""
        return "".join(
            " " * (self.spaces[n] + self.columns.get(n, 0)) + self.words[n]
            for n in range(start, end + 1)
        )

    def breaks(self, start: int, end: int) -> bool:
        """Returns whether a line end stays before any of the tokens `start .. end`."""
        return self.breaks_before[end + 1] > self.breaks_before[start]

    def fits(self, start: int, end: int, column: int) -> bool:
        """Returns whether the tokens can stand on one line from a column on."""
        return column + self.width(start, end) <= WIDTH and not self.breaks(start + 1, end)

    def align(self, lines: Sequence[Sequence[Range]], indent: int) -> None:
        """Aligns names, units and values of like declarations on neighbouring lines.

        Neighbours aren't aligned if one of them would become too long.

        Args:
          lines: the items of each line; one that shares its line isn't aligned.
          indent: columns of the lines.
        """
        for neighbours in self._neighbours(lines):
            # A row for each declaration: the tokens that begin its cells.
            rows = [(start, *self.structure.columns[start][1]) for start, _ in neighbours]
            added: dict[int, int] = {}  # token that begins a cell -> more spaces before it
            for column in range(len(rows[0]) - 1):
                widths = [self.width(row[column], row[column + 1] - 1) for row in rows]
                for row, width in zip(rows, widths, strict=True):
                    added[row[column + 1]] = max(widths) - width
            if all(self._has_room(start, end, indent, added) for start, end in neighbours):
                self.columns |= added

    def _neighbours(self, lines: Sequence[Sequence[Range]]) -> Iterator[list[Range]]:
        """Yields the items that share columns: of one rule, with no blank line between."""
        neighbours: list[Range] = []
        rule_of_neighbours = ""
        for line in lines:
            start = line[0][0]
            gap = self.gaps[start]
            rule = ""
            if len(line) == 1 and start in self.structure.columns:
                rule, _ = self.structure.columns[start]
            is_apart = gap.blank or any(comment.blank for comment in gap.comments)
            if neighbours and (is_apart or rule != rule_of_neighbours):
                yield neighbours
                neighbours = []
            if rule:
                neighbours.append(line[0])
                rule_of_neighbours = rule
        if neighbours:
            yield neighbours

    def _has_room(self, start: int, end: int, indent: int, added: dict[int, int]) -> bool:
        """Returns whether the first line of an item is short enough with the added spaces.

        If the item doesn't fit on one line, its first container will be open.
        """
        stops = self.structure.columns[start][1]
        if not self.fits(start, end, indent):
            rest = range(stops[-1], end + 1)
            end = next((n for n in rest if n in self.structure.containers), end)
        return self.fits(start, end, indent + sum(added[stop] for stop in stops))

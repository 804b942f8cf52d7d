"""The tokens of a text as the formatter sees them: what stands between them, their width on one line, and what shares columns."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import accumulate, pairwise

from lark import Token

from sjdsl.format.lines import WIDTH
from sjdsl.format.structure import Structure

BETWEEN_ITEMS = 2  # spaces between statements, or rows of a picture, on one line
Range = tuple[int, int]


@dataclass(frozen=True)
class Comment:
    """`trailing`: it stands behind a token, on its line. `blank`: a blank line stands before it."""

    text: str
    trailing: bool = False
    blank: bool = False


@dataclass(frozen=True)
class Gap:
    """What stands before a token. `ended`: at least one line end; `blank`: a blank line right before the token."""

    comments: tuple[Comment, ...] = ()
    ended: bool = False
    blank: bool = False


def read_gaps(text: str, tokens: Sequence[Token]) -> list[Gap]:
    """Returns the gap before each token and, last, the one behind them all.

    A comment that stands before `{` or `,` is moved behind it, so that these end the line they belong to.
    """
    starts = [*(token.start_pos or 0 for token in tokens), len(text)]
    ends = [0, *(token.end_pos or 0 for token in tokens)]
    gaps = [
        _read_gap(text[end:start], first=end == 0) for end, start in zip(ends, starts, strict=True)
    ]
    for number, token in enumerate(tokens):
        gap, behind = gaps[number], gaps[number + 1]
        if token.type in ("LBRACE", "COMMA") and gap.comments:
            others = (replace(comment, trailing=False) for comment in behind.comments)
            gaps[number], gaps[number + 1] = (
                Gap(),
                Gap((*gap.comments, *others), True, behind.blank),
            )
        elif token.type == "RBRACE":
            gaps[number] = replace(gap, blank=False)
    return gaps


def _read_gap(text: str, first: bool) -> Gap:
    *lines, last = text.split("\n")
    comments: list[Comment] = []
    blank = False
    for number, line in enumerate(lines if "#" not in last else (*lines, last)):
        words = line.strip()
        if words:
            comments.append(Comment(words, trailing=number == 0 and not first, blank=blank))
        blank = not words and number > 0
    return Gap(tuple(comments), bool(lines), blank)


class Tokens:
    """words: their texts. spaces: before each. ends: column behind each if all were one line. broken: whether a line ends before it.

    Line ends stay where comments are and where items or branches begin. places: tokens before which one stays where the author put it.
    columns: more spaces before some tokens, so that they stand in columns; no part measured here counts them.
    """

    def __init__(self, tokens: Sequence[Token], structure: Structure, gaps: Sequence[Gap]) -> None:
        self.structure, self.gaps = structure, gaps
        self.words = [str(token) for token in tokens]
        containers = structure.containers.values()
        items = {item: c.sort for c in containers for item in c.items[c.close is None :]}
        firsts = {c.open + 1 for c in containers}
        self.spaces = [0 if n in structure.tight else 1 for n in range(len(self.words))]
        for item, sort in items.items():
            self.spaces[item] = (
                BETWEEN_ITEMS if sort in ("block", "rows") and item not in firsts else 1
            )
        self.places = {structure.game, *items, *structure.branches, *(c.close for c in containers)}
        self.broken = [
            bool(gap.comments) or (gap.ended and n in self.places)
            for n, gap in enumerate(gaps[:-1])
        ]
        self.broken[self.words.index("{", structure.game) + 1] = (
            True  # the game's block is never on one line
        )
        self.breaks_before = [0, *accumulate(self.broken)]
        self.ends = list(
            accumulate(
                space + len(word) for space, word in zip(self.spaces, self.words, strict=True)
            )
        )
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

    def align(self, runs: Sequence[Sequence[Range]], indent: int) -> None:
        """Aligns names, units and values of declarations of one sort on neighbouring lines, in columns.

        runs: the items of each line; only those alone on their line take part. Neighbours that cannot all have the columns without longer
        lines than allowed have none.
        """
        for together in self._neighbours(runs):
            cells = [(start, *self.structure.columns[start][1]) for start, _ in together]
            widths = [[self.width(a, b - 1) for a, b in pairwise(row)] for row in cells]
            widest = [max(column) for column in zip(*widths, strict=True)]
            more: dict[
                int, int
            ] = {}  # the spaces that make each cell as wide as the widest one above or below
            for row, own in zip(cells, widths, strict=True):
                more |= {
                    token: wide - width
                    for token, width, wide in zip(row[1:], own, widest, strict=True)
                }
            if all(self._has_room(start, end, indent, more) for start, end in together):
                self.columns |= more

    def _neighbours(self, runs: Sequence[Sequence[Range]]) -> Iterator[list[Range]]:
        """Yields the items that share columns: of one sort, line below line, no blank line between."""
        together: list[Range] = []
        columns = self.structure.columns
        for run in runs:
            start = run[0][0]
            sort, gap = (
                columns[start][0] if len(run) == 1 and start in columns else "",
                self.gaps[start],
            )
            apart = gap.blank or any(comment.blank for comment in gap.comments)
            if together and (apart or columns[together[0][0]][0] != sort):
                yield together
                together = []
            together += [run[0]] if sort else []
        if together:
            yield together

    def _has_room(self, start: int, end: int, indent: int, more: dict[int, int]) -> bool:
        """Returns whether the first line of an item, which holds all its columns, is short enough with them."""
        stops = self.structure.columns[start][1]
        if not self.fits(start, end, indent):
            end = next(
                (n for n in range(stops[-1], end + 1) if n in self.structure.containers), end
            )
        return self.fits(start, end, indent + sum(more[stop] for stop in stops))

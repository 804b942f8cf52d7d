"""Breaks tokens into lines: what fits stays on one line, and line ends between items stay as the author set them.

Every choice depends on the tokens and on line ends between items alone, and those it adds lie between items: that is why a
second time changes nothing.
"""

from collections.abc import Iterator, Sequence

from lark import Token

from sjdsl.format.columns import shared_columns
from sjdsl.format.flat import Flat, make_flat
from sjdsl.format.gaps import Gap
from sjdsl.format.lines import WIDTH, Line, fits, wrapped
from sjdsl.format.structure import Container, Structure

INDENT, CONTINUED = 2, 4  # columns: of a block; of a line that goes on
# Where a line that is too long is best broken: before one of these, or behind a comma.
BREAKS = frozenset(
    ("and", "or", "where", "in", "to", "with", "when", "over", "after", "facing", "otherwise", "for", "by", "avoiding", "choose", "->")
)


def lay_out(tokens: Sequence[Token], structure: Structure, gaps: Sequence[Gap]) -> list[Line]:
    """Returns the lines of a file."""
    layout = Layout(make_flat(tokens, structure, gaps), structure, gaps)
    layout.begin(0, 0, first=True)
    layout.statement(0, structure.game - 1, 0)
    layout.begin(structure.game, 0)
    layout.statement(structure.game, len(tokens) - 1, 0)
    layout.comments_before(len(tokens), 0, blanks=True)
    return layout.lines


class Layout:
    """The lines so far; the last one is still written to. `head`: the line that its statement, or part of one, begins with."""

    def __init__(self, flat: Flat, structure: Structure, gaps: Sequence[Gap]) -> None:
        self.flat, self.structure, self.gaps = flat, structure, gaps
        self.lines: list[Line] = []
        self.head = 0

    # ---- lines

    def begin(self, token: int, indent: int, comments: int | None = None, first: bool = False, blanks: bool = True) -> None:
        """Begins a line for a token, after the comments before it. `first`: nothing stands above it in its block."""
        is_first = self.comments_before(token, indent if comments is None else comments, blanks, first)
        self.lines.append(Line(" " * indent, blank=self.gaps[token].blank and blanks and not is_first))
        self.head = len(self.lines) - 1

    def comments_before(self, token: int, indent: int, blanks: bool, first: bool = False) -> bool:
        """Writes the comments before a token: the first may end the line before, the others have lines of their own.

        Returns whether still nothing stands above the token in its block.
        """
        for comment in self.gaps[token].comments:
            if not comment.trailing:
                self._own_lines(comment.text, indent, comment.blank and blanks and not first)
                first = False
            elif fits(self.lines[-1].text, comment.text):
                self.lines[-1].comment = comment.text
            elif token not in self.flat.places or self.lines[self.head].text.lstrip().startswith("}"):
                self._own_lines(comment.text, indent, blank=False)
                first = False
            else:
                self._above(comment.text)
        return first

    def _own_lines(self, comment: str, indent: int, blank: bool) -> None:
        first, *others = wrapped(comment, indent)
        self.lines += [Line(first, blank=blank), *(Line(other) for other in others)]

    def _above(self, comment: str) -> None:
        """Puts a comment that is too long for the line it ends above the statement it is about."""
        head = self.lines[self.head]
        above = [Line(text) for text in wrapped(comment, len(head.text) - len(head.text.lstrip()))]
        above[0].blank, head.blank = head.blank, False
        self.lines[self.head : self.head] = above
        self.head += len(above)

    @property
    def column(self) -> int:
        return len(self.lines[-1].text)

    def _next_column(self, token: int) -> int:
        """Returns where a token would begin if it were written now."""
        return self.column + (self.flat.spaces[token] if self.lines[-1].text.strip() else 0)

    def write(self, start: int, end: int) -> None:
        """Adds tokens to the line, with a space before the first if it needs one."""
        is_new = not self.lines[-1].text.strip()
        self.lines[-1].text += self.flat.text(start, end).lstrip() if is_new else self.flat.text(start, end)

    # ---- items

    def items(self, container: Container, indent: int) -> None:
        """Writes the items of an open container, each line of them at `indent`; items on one line stay there if they fit."""
        runs = [line for run in self._runs(container) for line in self._split(run, indent)]
        self.flat.columns.update(shared_columns(runs, indent, self.flat, self.structure, self.gaps))
        for number, run in enumerate(runs):
            self.begin(run[0][0], indent, first=number == 0)
            self.statement(run[0][0], run[-1][1], indent)

    def _split(self, run: list[tuple[int, int]], indent: int) -> list[list[tuple[int, int]]]:
        """Returns the items line by line: all on one if they fit."""
        return [run] if self.flat.fits(run[0][0], run[-1][1], indent) else [[item] for item in run]

    def _runs(self, container: Container) -> Iterator[list[tuple[int, int]]]:
        """Yields the items that the author put on one line; rows of a picture never share one."""
        run: list[tuple[int, int]] = []
        for start, end in container.ranges():
            if run and (self.flat.broken[start] or container.sort == "rows"):
                yield run
                run = []
            run.append((start, end))
        if run:
            yield run

    def statement(self, start: int, end: int, indent: int) -> None:
        """Writes a statement that begins the line: on one line, or each branch on its own and what does not fit opened."""
        if self.flat.fits(start, end, indent):
            self.write(start, end)
            return
        is_open = False
        for number, (first, last) in enumerate(self._branches(start, end)):
            if number and not (is_open and not self.flat.commented[first]):
                self.begin(first, indent, blanks=False)
            is_open = not self.flat.fits(first, last, self._next_column(first))
            if is_open:
                self.opened(first, last, indent)
            else:
                self.write(first, last)

    def _branches(self, start: int, end: int) -> Iterator[tuple[int, int]]:
        """Yields the parts of a statement: up to its first `otherwise`, and each one that follows."""
        at, first = start, start
        while at <= end:
            if at in self.structure.branches and at > start:
                yield first, at - 1
                first = at
            inner = self.structure.containers.get(at)
            at = inner.end + 1 if inner is not None else at + 1
        yield first, end

    def opened(self, start: int, end: int, indent: int) -> None:
        """Writes what does not fit on one line: its blocks and lists opened, the parts before and behind them wrapped."""
        at = start
        for container in self._to_open(start, end, indent):
            self.wrapped(at, container.open, indent)
            at = self._inside(container, end, indent)
        self.wrapped(at, end, indent)

    def _inside(self, container: Container, end: int, indent: int) -> int:
        """Writes the items of a container; returns the token to go on with, which has its place."""
        if container.sort == "texts" or self._hangs(container):
            self._hanging(container)
        else:
            self.items(container, indent + INDENT)
        close = container.close
        if close is None:
            return container.end + 1
        is_near = container.sort != "block" and not self.flat.broken[close]
        if not (is_near and self.flat.fits(close, self._part_end(close, end), self._next_column(close))):
            self.begin(close, indent, comments=indent + INDENT, first=not container.items)
        return close

    def _part_end(self, start: int, end: int) -> int:
        """Returns the last token that is written before the next container that is open."""
        opened = (c.open for c in self._containers(start + 1, end) if self.flat.breaks(c.open + 1, c.end))
        return next(opened, end)

    def _to_open(self, start: int, end: int, indent: int) -> list[Container]:
        """Returns the containers to open: blocks, all with line ends inside, and the lists in parts that are too long."""
        found = list(self._containers(start, end))
        opened = [c for c in found if c.sort == "block" or self.flat.breaks(c.open + 1, c.end)]
        edges = [start, *(c.end if c.close is None else c.close for c in opened)]
        parts = zip(edges, [*(c.open for c in opened), end], strict=True)
        for first, last in parts:
            column = self._next_column(start) if first == start else indent  # a branch may begin behind the `}` of the one before
            if column + self.flat.width(first, last) > WIDTH:
                opened += [c for c in found if first <= c.open and c.end <= last and c not in opened]
        return sorted(opened, key=lambda c: c.open)

    def _containers(self, start: int, end: int) -> Iterator[Container]:
        """Yields the containers of some tokens that lie in no other one."""
        at = start
        while at <= end:
            inner = self.structure.containers.get(at)
            if inner is not None:
                yield inner
            at = inner.end + 1 if inner is not None else at + 1

    # ---- parts of statements

    def _hangs(self, container: Container) -> bool:
        """Returns whether the rows of a picture stand below the first one, which stands behind the brace."""
        if container.sort != "rows" or self.flat.broken[container.items[0]]:
            return False
        breaks = any(self.flat.broken[row] for row in container.items[1:])
        widest = max(self.flat.width(row, row) for row in container.items)
        return breaks and self.column + 1 + widest + len(" }") <= WIDTH

    def _hanging(self, container: Container) -> None:
        """Writes rows or texts one below the other, the first behind what opens them unless a comment is between."""
        first, *others = container.items
        self.wrapped(first, first, self.column - CONTINUED)
        column = self.column - self.flat.width(first, first)
        for item in others:
            self.begin(item, column, blanks=False)
            self.write(item, item)

    def wrapped(self, start: int, end: int, indent: int) -> None:
        """Adds tokens to the line; the line goes on in the next, further right, after a comment and where it is full."""
        at = start
        while at <= end:
            stop = next((n for n in range(at + 1, end + 1) if self.flat.commented[n]), end + 1)
            if self.flat.commented[at] and self.lines[-1].text.strip():
                self.begin(at, indent + CONTINUED, blanks=False)
            self._fill(at, stop - 1, indent)
            at = stop

    def _fill(self, start: int, end: int, indent: int) -> None:
        """Adds tokens without comments between them to the line, and goes on in the next where it is full."""
        while not self.flat.fits(start, end, self._next_column(start)):
            cut = self._last_break(start, end)
            if cut is None:
                break
            self.write(start, cut - 1)
            self.lines.append(Line(" " * (indent + CONTINUED)))
            start = cut
        self.write(start, end)

    def _last_break(self, start: int, end: int) -> int | None:
        """Returns the token to begin the next line with: the last good one that leaves this line short enough, or any."""
        good, possible = None, None
        for n in (n for n in range(start + 1, end + 1) if self.flat.spaces[n]):
            if possible is not None and not self.flat.fits(start, n - 1, self._next_column(start)):
                break
            possible = n
            if self.flat.words[n] in BREAKS or self.flat.words[n - 1] == ",":
                good = n
        return possible if good is None else good

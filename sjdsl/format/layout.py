"""Breaks tokens into lines: what fits stays on one line, and line ends between items stay as the author set them.

Every choice depends on the tokens and on line ends between items alone, and those it adds lie between items: that is why a
second time changes nothing.
"""

from collections.abc import Iterator

from sjdsl.format.lines import APART, WIDTH, Line, wrapped
from sjdsl.format.structure import Container
from sjdsl.format.tokens import Tokens

INDENT, CONTINUED = 2, 4  # columns: of a block; of a line that goes on
# Where a line that is too long is best broken: before one of these, or behind a comma.
BREAKS = frozenset((
    "and", "or", "where", "in", "to", "with", "when", "over", "after", "facing", "otherwise", "for", "by", "avoiding", "choose", "->",
))  # fmt: skip


def lay_out(tokens: Tokens) -> list[Line]:
    """Returns the lines of a file."""
    layout, game, last = Layout(tokens), tokens.structure.game, len(tokens.words)
    layout.begin(0, 0, first=True)
    layout.statement(0, game - 1, 0)
    layout.begin(game, 0)
    layout.statement(game, last - 1, 0)
    layout.comments_before(last, 0, blanks=True)
    return layout.lines


class Layout:
    """The lines so far; the last one is still written to. `head`: the line that its statement, or part of one, begins with."""

    def __init__(self, tokens: Tokens) -> None:
        self.tokens, self.structure, self.gaps = tokens, tokens.structure, tokens.gaps
        self.lines: list[Line] = []
        self.head = 0

    # ---- lines

    def begin(
        self,
        token: int,
        indent: int,
        comments: int | None = None,
        first: bool = False,
        blanks: bool = True,
    ) -> None:
        """Begins a line for a token, after the comments before it. `first`: nothing stands above it in its block."""
        is_first = self.comments_before(
            token, indent if comments is None else comments, blanks, first
        )
        self.lines.append(
            Line(" " * indent, blank=self.gaps[token].blank and blanks and not is_first)
        )
        self.head = len(self.lines) - 1

    def comments_before(self, token: int, indent: int, blanks: bool, first: bool = False) -> bool:
        """Writes the comments before a token: the first may end the line before, the others have lines of their own.

        Returns whether still nothing stands above the token in its block.
        """
        for comment in self.gaps[token].comments:
            last, head = (
                (self.lines[-1], self.lines[self.head]) if self.lines else (Line(""), Line(""))
            )
            if comment.trailing and len(last.text) + APART + len(comment.text) <= WIDTH:
                last.comment = comment.text
            elif (
                comment.trailing
                and token in self.tokens.places
                and not head.text.lstrip().startswith("}")
            ):
                # too long for the line it ends: above the statement it is about
                above = [Line(text) for text in wrapped(comment.text, head.indent)]
                above[0].blank, head.blank = head.blank, False
                self.lines[self.head : self.head] = above
                self.head += len(above)
            else:
                blank = comment.blank and blanks and not first and not comment.trailing
                text, *others = wrapped(comment.text, indent)
                self.lines += [Line(text, blank=blank), *(Line(other) for other in others)]
                first = False
        return first

    @property
    def column(self) -> int:
        return len(self.lines[-1].text)

    def _next_column(self, token: int) -> int:
        """Returns where a token would begin if it were written now."""
        return self.column + (self.tokens.spaces[token] if self.lines[-1].text.strip() else 0)

    def write(self, start: int, end: int) -> None:
        """Adds tokens to the line, with a space before the first if it needs one."""
        is_new = not self.lines[-1].text.strip()
        self.lines[-1].text += (
            self.tokens.text(start, end).lstrip() if is_new else self.tokens.text(start, end)
        )

    # ---- items

    def items(self, container: Container, indent: int) -> None:
        """Writes the items of an open container, each line of them at `indent`; items on one line stay there if they fit."""
        runs: list[list[tuple[int, int]]] = []
        for run in self._runs(container):
            runs += (
                [run]
                if self.tokens.fits(run[0][0], run[-1][1], indent)
                else [[item] for item in run]
            )
        self.tokens.align(runs, indent)
        for number, run in enumerate(runs):
            self.begin(run[0][0], indent, first=number == 0)
            self.statement(run[0][0], run[-1][1], indent)

    def _runs(self, container: Container) -> Iterator[list[tuple[int, int]]]:
        """Yields the items that the author put on one line; rows of a picture never share one."""
        run: list[tuple[int, int]] = []
        for start, end in container.ranges():
            if run and (self.tokens.broken[start] or container.sort == "rows"):
                yield run
                run = []
            run.append((start, end))
        if run:
            yield run

    def statement(self, start: int, end: int, indent: int) -> None:
        """Writes a statement that begins the line: on one line, or each branch on its own and what does not fit opened."""
        if self.tokens.fits(start, end, indent):
            self.write(start, end)
            return
        is_open = False
        for number, (first, last) in enumerate(self._branches(start, end)):
            if number and not (is_open and not self.gaps[first].comments):
                self.begin(first, indent, blanks=False)
            is_open = not self.tokens.fits(first, last, self._next_column(first))
            if is_open:
                self.opened(first, last, indent)
            else:
                self.write(first, last)

    def _branches(self, start: int, end: int) -> Iterator[tuple[int, int]]:
        """Yields the parts of a statement: up to its first `otherwise`, and each one that follows."""
        first = start
        for at in self._outside(start, end):
            if at in self.structure.branches and at > start:
                yield first, at - 1
                first = at
        yield first, end

    def _outside(self, start: int, end: int) -> Iterator[int]:
        """Yields the tokens `start .. end` that lie in no container, and those that open one."""
        at = start
        while at <= end:
            yield at
            inner = self.structure.containers.get(at)
            at = inner.end + 1 if inner is not None else at + 1

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
        is_near = container.sort != "block" and not self.tokens.broken[close]
        opened = (
            c.open
            for c in self._outermost_containers(close + 1, end)
            if self.tokens.breaks(c.open + 1, c.end)
        )
        part_end = next(
            opened, end
        )  # the last token that is written before the next container that is open
        if not (is_near and self.tokens.fits(close, part_end, self._next_column(close))):
            self.begin(close, indent, comments=indent + INDENT, first=not container.items)
        return close

    def _to_open(self, start: int, end: int, indent: int) -> list[Container]:
        """Returns the containers to open: blocks, all with line ends inside, and the lists in parts that are too long."""
        found = list(self._outermost_containers(start, end))
        opened = [c for c in found if c.sort == "block" or self.tokens.breaks(c.open + 1, c.end)]
        edges = [start, *(c.end if c.close is None else c.close for c in opened)]
        parts = zip(edges, [*(c.open for c in opened), end], strict=True)
        for first, last in parts:
            column = (
                self._next_column(start) if first == start else indent
            )  # a branch may begin behind the `}` of the one before
            if column + self.tokens.width(first, last) > WIDTH:
                opened += [
                    c for c in found if first <= c.open and c.end <= last and c not in opened
                ]
        return sorted(opened, key=lambda c: c.open)

    def _outermost_containers(self, start: int, end: int) -> Iterator[Container]:
        """Yields the containers of some tokens that lie in no other one."""
        yield from (
            self.structure.containers[at]
            for at in self._outside(start, end)
            if at in self.structure.containers
        )

    # ---- parts of statements

    def _hangs(self, container: Container) -> bool:
        """Returns whether the rows of a picture stand below the first one, which stands behind the brace."""
        if container.sort != "rows" or self.tokens.broken[container.items[0]]:
            return False
        breaks = any(self.tokens.broken[row] for row in container.items[1:])
        widest = max(self.tokens.width(row, row) for row in container.items)
        return breaks and self.column + 1 + widest + len(" }") <= WIDTH

    def _hanging(self, container: Container) -> None:
        """Writes rows or texts one below the other, the first behind what opens them unless a comment is between."""
        first, *others = container.items
        self.wrapped(first, first, self.column - CONTINUED)
        column = self.column - self.tokens.width(first, first)
        for item in others:
            self.begin(item, column, blanks=False)
            self.write(item, item)

    def wrapped(self, start: int, end: int, indent: int) -> None:
        """Adds tokens to the line; the line goes on in the next, further right, after a comment and where it is full."""
        at = start
        while at <= end:
            stop = next((n for n in range(at + 1, end + 1) if self.gaps[n].comments), end + 1)
            if self.gaps[at].comments and self.lines[-1].text.strip():
                self.begin(at, indent + CONTINUED, blanks=False)
            self._fill(at, stop - 1, indent)
            at = stop

    def _fill(self, start: int, end: int, indent: int) -> None:
        """Adds tokens without comments between them to the line, and goes on in the next where it is full."""
        while not self.tokens.fits(start, end, self._next_column(start)):
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
        for n in (n for n in range(start + 1, end + 1) if self.tokens.spaces[n]):
            if possible is not None and not self.tokens.fits(
                start, n - 1, self._next_column(start)
            ):
                break
            possible = n
            if self.tokens.words[n] in BREAKS or self.tokens.words[n - 1] == ",":
                good = n
        return possible if good is None else good

"""Breaks tokens into lines: what fits stays on one line, and so do line ends between items.

Every choice depends on the tokens and on line ends between items alone, and new line ends lie
between items. Therefore, formatting twice changes no more than formatting once.
"""

from collections.abc import Iterator

from sjdsl.format.lines import APART, WIDTH, Line, wrapped
from sjdsl.format.structure import Container
from sjdsl.format.tokens import Range, Tokens

INDENT = 2  # columns of a block
CONTINUED = 4  # columns of a line that continues another
# A line that is too long is best broken before one of these, or behind a comma.
BREAKS = frozenset((
    "and", "or", "where", "in", "to", "with", "when", "over", "after", "facing", "otherwise", "for",
    "by", "avoiding", "choose", "->",
))  # fmt: skip


def lay_out(tokens: Tokens) -> list[Line]:
    """Returns the lines of a file."""
    layout = Layout(tokens)
    game = tokens.structure.game
    end = len(tokens.words)
    layout.begin(0, 0, first=True)
    layout.statement(0, game - 1, 0)
    layout.begin(game, 0)
    layout.statement(game, end - 1, 0)
    layout.comments_before(end, 0, blanks=True)
    return layout.lines


class Layout:
    """The lines so far; the last one is still being written.

    head: the index of the line with which its statement, or a branch of it, begins.
    """

    def __init__(self, tokens: Tokens) -> None:
        self.tokens = tokens
        self.structure = tokens.structure
        self.gaps = tokens.gaps
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
        """Begins a line for a token, after the comments before it.

        Args:
          indent: columns of the line.
          comments: columns of the comments, by default the same.
          first: whether nothing stands above the token in its block.
          blanks: whether blank lines are kept.
        """
        comment_indent = indent if comments is None else comments
        is_first = self.comments_before(token, comment_indent, blanks, first)
        is_blank = self.gaps[token].blank and blanks and not is_first
        self.lines.append(Line(" " * indent, blank=is_blank))
        self.head = len(self.lines) - 1

    def comments_before(self, token: int, indent: int, blanks: bool, first: bool = False) -> bool:
        """Writes the comments before a token, at the end of the last line or on their own lines.

        Returns whether still nothing stands above the token in its block.
        """
        for comment in self.gaps[token].comments:
            last = self.lines[-1] if self.lines else Line("")
            head = self.lines[self.head] if self.lines else Line("")
            if comment.trailing and len(last.text) + APART + len(comment.text) <= WIDTH:
                last.comment = comment.text
            elif (
                comment.trailing
                and token in self.tokens.places
                and not head.text.lstrip().startswith("}")
            ):
                # It is too long to end the line, and goes above its statement.
                self._insert_above_head(wrapped(comment.text, head.indent))
            else:
                is_blank = comment.blank and blanks and not first and not comment.trailing
                text, *others = wrapped(comment.text, indent)
                self.lines += [Line(text, blank=is_blank), *map(Line, others)]
                first = False
        return first

    def _insert_above_head(self, texts: list[str]) -> None:
        """Inserts lines above the item that is being written; it loses its blank line to them."""
        head = self.lines[self.head]
        lines = [Line(text) for text in texts]
        lines[0].blank = head.blank
        head.blank = False
        self.lines[self.head : self.head] = lines
        self.head += len(lines)

    @property
    def column(self) -> int:
        """The width of the last line."""
        return len(self.lines[-1].text)

    @property
    def _is_empty(self) -> bool:
        """Whether the last line has no tokens."""
        return not self.lines[-1].text.strip()

    def _next_column(self, token: int) -> int:
        """Returns the column at which a token would begin."""
        return self.column if self._is_empty else self.column + self.tokens.spaces[token]

    def write(self, start: int, end: int) -> None:
        """Adds the tokens `start .. end` to the line, with a space before if they need one."""
        text = self.tokens.text(start, end)
        self.lines[-1].text += text.lstrip() if self._is_empty else text

    # ---- items

    def items(self, container: Container, indent: int) -> None:
        """Writes the items of an open container at `indent`; those on one line stay if they fit."""
        lines: list[list[Range]] = []
        for line in self._lines_of(container):
            if self.tokens.fits(line[0][0], line[-1][1], indent):
                lines.append(line)
            else:
                lines += [[item] for item in line]
        self.tokens.align(lines, indent)
        for number, line in enumerate(lines):
            self.begin(line[0][0], indent, first=number == 0)
            self.statement(line[0][0], line[-1][1], indent)

    def _lines_of(self, container: Container) -> Iterator[list[Range]]:
        """Yields the items that the author put on one line; rows of a picture never share one."""
        line: list[Range] = []
        for start, end in container.ranges():
            if line and (self.tokens.broken[start] or container.content == "rows"):
                yield line
                line = []
            line.append((start, end))
        if line:
            yield line

    def statement(self, start: int, end: int, indent: int) -> None:
        """Writes a statement that begins a line.

        If it doesn't fit on the line, each branch has its own; what still doesn't fit is opened.
        """
        if self.tokens.fits(start, end, indent):
            self.write(start, end)
            return
        is_open = False
        for first, last in self._branches(start, end):
            if first > start and not (is_open and not self.gaps[first].comments):
                self.begin(first, indent, blanks=False)
            is_open = not self.tokens.fits(first, last, self._next_column(first))
            if is_open:
                self.opened(first, last, indent)
            else:
                self.write(first, last)

    def _branches(self, start: int, end: int) -> Iterator[Range]:
        """Yields the parts of a statement: up to its first `otherwise`, and from each one on."""
        first = start
        for token in self._outside(start, end):
            if token in self.structure.branches and token > start:
                yield first, token - 1
                first = token
        yield first, end

    def _outside(self, start: int, end: int) -> Iterator[int]:
        """Yields the tokens `start .. end` that lie in no container, and those that open one."""
        token = start
        while token <= end:
            yield token
            inner = self.structure.containers.get(token)
            token = token + 1 if inner is None else inner.end + 1

    def opened(self, start: int, end: int, indent: int) -> None:
        """Writes what doesn't fit on one line: its containers opened, the parts between wrapped."""
        first = start
        for container in self._to_open(start, end, indent):
            self.wrapped(first, container.open, indent)
            first = self._contents(container, end, indent)
        self.wrapped(first, end, indent)

    def _contents(self, container: Container, end: int, indent: int) -> int:
        """Writes the items of a container, and begins a line for its end if it needs one.

        Returns the token to go on with. `end` is the last token of the statement.
        """
        if container.content == "texts" or self._hangs(container):
            self._hanging(container)
        else:
            self.items(container, indent + INDENT)
        close = container.close
        if close is None:
            return container.end + 1
        part_end = end  # the last token before the next container that will be open
        for following in self._outermost_containers(close + 1, end):
            if self.tokens.breaks(following.open + 1, following.end):
                part_end = following.open
                break
        stays = container.content != "block" and not self.tokens.broken[close]
        if not (stays and self.tokens.fits(close, part_end, self._next_column(close))):
            self.begin(close, indent, comments=indent + INDENT, first=not container.items)
        return close

    def _to_open(self, start: int, end: int, indent: int) -> list[Container]:
        """Returns the containers to open.

        These are blocks, those with line ends inside, and those in parts that are too long.
        """
        containers = list(self._outermost_containers(start, end))
        opened = [
            c for c in containers if c.content == "block" or self.tokens.breaks(c.open + 1, c.end)
        ]
        # Between the opened containers are parts that would stay on one line.
        starts = [start, *(c.end if c.close is None else c.close for c in opened)]
        ends = [*(c.open for c in opened), end]
        for first, last in zip(starts, ends, strict=True):
            # A branch may begin behind the `}` of the one before.
            column = self._next_column(start) if first == start else indent
            if column + self.tokens.width(first, last) > WIDTH:
                inside = [c for c in containers if first <= c.open and c.end <= last]
                opened += [c for c in inside if c not in opened]
        return sorted(opened, key=lambda c: c.open)

    def _outermost_containers(self, start: int, end: int) -> Iterator[Container]:
        """Yields the containers among some tokens that lie in no other one."""
        for token in self._outside(start, end):
            if token in self.structure.containers:
                yield self.structure.containers[token]

    # ---- parts of statements

    def _hangs(self, container: Container) -> bool:
        """Returns whether rows of a picture stand below the first, which is behind the brace."""
        if container.content != "rows" or self.tokens.broken[container.items[0]]:
            return False
        breaks = any(self.tokens.broken[row] for row in container.items[1:])
        widest = max(self.tokens.width(row, row) for row in container.items)
        return breaks and self.column + 1 + widest + len(" }") <= WIDTH

    def _hanging(self, container: Container) -> None:
        """Writes rows or texts below each other; the first, if it has no comment, on this line."""
        first, *others = container.items
        self.wrapped(first, first, self.column - CONTINUED)
        column = self.column - self.tokens.width(first, first)
        for item in others:
            self.begin(item, column, blanks=False)
            self.write(item, item)

    def wrapped(self, start: int, end: int, indent: int) -> None:
        """Adds tokens to the line, and goes on in the next after a comment or where it is full."""
        first = start
        while first <= end:
            stop = next((n for n in range(first + 1, end + 1) if self.gaps[n].comments), end + 1)
            if self.gaps[first].comments and not self._is_empty:
                self.begin(first, indent + CONTINUED, blanks=False)
            self._fill(first, stop - 1, indent)
            first = stop

    def _fill(self, start: int, end: int, indent: int) -> None:
        """Adds tokens without comments to the line, and goes on in the next where it is full."""
        while not self.tokens.fits(start, end, self._next_column(start)):
            cut = self._last_break(start, end)
            if cut is None:
                break
            self.write(start, cut - 1)
            self.lines.append(Line(" " * (indent + CONTINUED)))
            start = cut
        self.write(start, end)

    def _last_break(self, start: int, end: int) -> int | None:
        """Returns the token that begins the next line, None if the line can't be broken.

        It is the last good one that leaves this line short enough, or else the last possible one.
        """
        column = self._next_column(start)
        good: int | None = None
        possible: int | None = None
        for n in range(start + 1, end + 1):
            if not self.tokens.spaces[n]:
                continue
            if possible is not None and not self.tokens.fits(start, n - 1, column):
                break
            possible = n
            if self.tokens.words[n] in BREAKS or self.tokens.words[n - 1] == ",":
                good = n
        return possible if good is None else good

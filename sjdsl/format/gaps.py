"""The text between tokens: comments, line ends, blank lines."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from lark import Token


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
    gaps = [_read(text[end:start], first=end == 0) for end, start in zip(ends, starts, strict=True)]
    for number, token in enumerate(tokens):
        if token.type in ("LBRACE", "COMMA") and gaps[number].comments:
            gaps[number + 1] = _joined(gaps[number], gaps[number + 1])
            gaps[number] = Gap()
        elif token.type == "RBRACE":
            gaps[number] = replace(gaps[number], blank=False)
    return gaps


def _read(text: str, first: bool) -> Gap:
    *lines, last = text.split("\n")
    comments: list[Comment] = []
    blank = False
    for number, line in enumerate(lines if "#" not in last else (*lines, last)):
        words = line.strip()
        if words:
            comments.append(Comment(words, trailing=number == 0 and not first, blank=blank))
        blank = not words and number > 0
    return Gap(tuple(comments), bool(lines), blank)


def _joined(gap: Gap, behind: Gap) -> Gap:
    others = [replace(comment, trailing=False) for comment in behind.comments]
    return Gap((*gap.comments, *others), True, behind.blank)

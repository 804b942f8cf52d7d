"""Writes lines of code with their comments; those of neighbouring lines are aligned."""

from collections.abc import Sequence
from dataclasses import dataclass

WIDTH = 140  # columns
FAR = 30  # columns: comments of lines whose lengths differ by more aren't aligned
APART = 2  # columns between code and its comment


@dataclass
class Line:
    """A line.

    text: code with its indentation; comment: behind the code, "" if there is none; blank: whether
    an empty line stands before it.
    """

    text: str
    comment: str = ""
    blank: bool = False

    @property
    def indent(self) -> int:
        return len(self.text) - len(self.text.lstrip())


def wrapped(comment: str, indent: int) -> list[str]:
    """Returns a comment on its own lines; what is too long continues on the next."""
    rest = " " * indent + comment
    lines = []
    while len(rest) > WIDTH:
        first_word = len(rest) - len(rest[indent:].lstrip("# "))
        cut = rest.rfind(" ", first_word, WIDTH + 1)
        if cut < 0:
            cut = rest.find(" ", WIDTH)
        if cut < 0:
            break
        lines.append(rest[:cut].rstrip())
        rest = " " * indent + "# " + rest[cut:].strip()
    return [*lines, rest]


def render(lines: Sequence[Line]) -> str:
    """Returns the text of lines; comments of lines with one indentation are aligned."""
    runs: list[list[Line]] = []
    for number, line in enumerate(lines):
        if number == 0 or line.blank or line.indent != lines[number - 1].indent:
            runs.append([])
        runs[-1].append(line)
    texts: list[str] = []
    for run in runs:
        if run[0].blank and texts:
            texts.append("")
        columns = _comment_columns(run)
        for number, line in enumerate(run):
            text = line.text
            if line.comment:
                text = text.ljust(columns[number]) + line.comment
            texts.append(text)
    return "".join(f"{text}\n" for text in texts)


def _comment_columns(run: Sequence[Line]) -> dict[int, int]:
    """Returns the column of each comment of a run, by the number of its line.

    Comments share a column unless one line is far longer, or a comment would become too long.
    """
    lengths = {number: len(line.text) for number, line in enumerate(run) if line.comment}
    columns: dict[int, int] = {}
    while lengths:
        limit = min(lengths.values()) + FAR
        near = {number: length for number, length in lengths.items() if length <= limit}
        shared = max(near.values()) + APART
        for number, length in near.items():
            is_aligned = shared + len(run[number].comment) <= WIDTH
            columns[number] = shared if is_aligned else length + APART
            del lengths[number]
    return columns

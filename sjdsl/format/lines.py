"""Writes lines of code with their comments, aligning comments of neighbouring lines."""

from collections.abc import Sequence
from dataclasses import dataclass

WIDTH = 140  # columns
FAR = 30  # columns: comments of lines whose lengths differ by more do not share a column
APART = 2  # columns between code and its comment


@dataclass
class Line:
    """`text`: with its indentation. `comment`: behind the code, empty if there is none. `blank`: an empty line before it."""

    text: str
    comment: str = ""
    blank: bool = False

    @property
    def indent(self) -> int:
        return len(self.text) - len(self.text.lstrip())


def wrapped(comment: str, indent: int) -> list[str]:
    """Returns a comment as lines of their own; one that is too long continues on the next line."""
    rest = " " * indent + comment
    found = []
    while len(rest) > WIDTH:
        begin = len(rest) - len(
            rest[indent:].lstrip("# ")
        )  # a cut before its first word would leave an empty line
        cut = rest.rfind(" ", begin, WIDTH + 1)
        cut = cut if cut >= 0 else rest.find(" ", WIDTH)
        if cut < 0:
            break
        found.append(rest[:cut].rstrip())
        rest = " " * indent + "# " + rest[cut:].strip()
    return [*found, rest]


def render(lines: Sequence[Line]) -> str:
    """Returns the text of the lines, comments below each other in a run of equally indented lines."""
    runs: list[list[Line]] = []
    for number, line in enumerate(lines):
        if number == 0 or line.blank or line.indent != lines[number - 1].indent:
            runs.append([])
        runs[-1].append(line)
    found: list[str] = []
    for run in runs:
        columns = _comment_columns(run)
        found += [""] if run[0].blank and found else []
        found += [
            f"{line.text:{columns[n]}}{line.comment}" if line.comment else line.text
            for n, line in enumerate(run)
        ]
    return "".join(f"{line}\n" for line in found)


def _comment_columns(run: Sequence[Line]) -> dict[int, int]:
    """Returns the columns of comments in one run: those of far longer lines have a column of their own, or stand alone."""
    lengths = {number: len(line.text) for number, line in enumerate(run) if line.comment}
    columns: dict[int, int] = {}
    while lengths:
        near = [
            number for number, length in lengths.items() if length <= min(lengths.values()) + FAR
        ]
        shared = max(lengths[number] for number in near) + APART
        for number in near:
            length = lengths.pop(number)
            columns[number] = (
                shared if shared + len(run[number].comment) <= WIDTH else length + APART
            )
    return columns

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


def fits(text: str, comment: str) -> bool:
    """Returns whether a comment fits on the line of its code."""
    return len(text) + APART + len(comment) <= WIDTH


def wrapped(comment: str, indent: int) -> list[str]:
    """Returns a comment as lines of their own; one that is too long goes on in the next line."""
    rest = " " * indent + comment
    found = []
    while len(rest) > WIDTH:
        begin = len(rest) - len(rest[indent:].lstrip("# "))  # a cut before its first word would leave an empty line
        cut = rest.rfind(" ", begin, WIDTH + 1)
        cut = cut if cut >= 0 else rest.find(" ", WIDTH)
        if cut < 0:
            break
        found.append(rest[:cut].rstrip())
        rest = " " * indent + "# " + rest[cut:].strip()
    return [*found, rest]


def render(lines: Sequence[Line]) -> str:
    """Returns the text of the lines."""
    columns = _comment_columns(lines)
    found: list[str] = []
    for number, line in enumerate(lines):
        found += [""] if line.blank and found else []
        found.append(f"{line.text:{columns[number]}}{line.comment}" if line.comment else line.text)
    return "".join(f"{line}\n" for line in found)


def _comment_columns(lines: Sequence[Line]) -> dict[int, int]:
    """Returns where the comment of each line that has one begins: below each other in a run of equally indented lines."""
    columns: dict[int, int] = {}
    run: list[int] = []
    for number, line in enumerate(lines):
        if run and (line.blank or _indent(line) != _indent(lines[number - 1])):
            columns |= _columns_of(run, lines)
            run = []
        run += [number] if line.comment else []
    return columns | _columns_of(run, lines)


def _indent(line: Line) -> int:
    return len(line.text) - len(line.text.lstrip())


def _columns_of(run: Sequence[int], lines: Sequence[Line]) -> dict[int, int]:
    """Returns the columns of comments in one run: those of far longer lines have a column of their own, or stand alone."""
    columns: dict[int, int] = {}
    while run:
        lengths = {number: len(lines[number].text) for number in run}
        near = [number for number in run if lengths[number] <= min(lengths.values()) + FAR]
        shared = max(lengths[number] for number in near) + APART
        for number in near:
            columns[number] = shared if shared + len(lines[number].comment) <= WIDTH else lengths[number] + APART
        run = [number for number in run if number not in columns]
    return columns

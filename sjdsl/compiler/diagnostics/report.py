"""Prints diagnostics: as text with the lines they are about, or as plain data for a program."""

import unicodedata
from bisect import bisect_left, bisect_right
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from sjdsl.compiler.diagnostics.diagnostic import Diagnostic
from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.diagnostics.source import Source, Span

WIDTH = 100  # columns of an excerpt; a longer line is cut around what the message is about
NARROWEST = 40  # columns of an excerpt in the narrowest terminal
BEFORE = 20  # columns shown before what a message is about, if it begins far to the right
TAB = 4
LINES = 4  # a longer span shows its first and last line only
RED = "\x1b[31m"
YELLOW = "\x1b[33m"
BLUE = "\x1b[34m"
BOLD = "\x1b[1m"
PLAIN = "\x1b[0m"


class Mark(Record):
    """The part `start .. end` of a line, in characters from 0, with a sign and a text."""

    line: int
    start: int
    end: int
    sign: str
    text: str = ""


def render(
    diagnostics: Sequence[Diagnostic],
    sources: Mapping[str, Source],
    colour: bool,
    width: int | None = None,
) -> str:
    """Returns the diagnostics as text for a terminal, with the number of errors and warnings.

    width: the terminal's columns, at which excerpts are cut; None: excerpts have up to `WIDTH`.
    """
    if not diagnostics:
        return ""
    parts = [_render_one(d, sources, colour, width) for d in diagnostics]
    counts = Counter(d.severity for d in diagnostics)
    summary = []
    for name in ("error", "warning"):
        if counts[name] == 1:
            summary.append(f"1 {name}")
        elif counts[name]:
            summary.append(f"{counts[name]} {name}s")
    return "\n".join([*parts, ", ".join(summary)])


def to_json(
    diagnostics: Sequence[Diagnostic], sources: Mapping[str, Source] | None = None
) -> list[dict[str, Any]]:
    """Returns the diagnostics as plain data.

    Without the text of its file, a span is taken to end in the line it begins in.
    """
    known = sources or {}
    return [
        {
            "code": d.code,
            "severity": d.severity,
            "message": d.message,
            "hint": d.hint,
            **_place(d.span, known),
            "labels": [{"text": label.text, **_place(label.span, known)} for label in d.labels],
            "fix": {"text": d.fix.text, **_place(d.fix.span, known)} if d.fix else None,
        }
        for d in diagnostics
    ]


def _place(span: Span, sources: Mapping[str, Source]) -> dict[str, Any]:
    """Returns a span as JSON."""
    end_line = span.line
    end_column = span.column + span.end - span.start
    if span.file in sources:
        end = sources[span.file].span(span.end, span.end)
        end_line = end.line
        end_column = end.column
    return {
        "file": span.file,
        "line": span.line,
        "column": span.column,
        "end_line": end_line,
        "end_column": end_column,
    }


def _render_one(
    d: Diagnostic, sources: Mapping[str, Source], colour: bool, width: int | None
) -> str:
    """Returns a diagnostic as text: its message, the lines it is about, and its help."""
    tint = RED if d.severity == "error" else YELLOW
    head = _paint(f"{d.severity}[{d.code}]", tint + BOLD, colour)
    place = f"{visible(d.span.file)}:{d.span.line}:{d.span.column}"
    lines = [f"{head} {_paint(place, BOLD, colour)}", f"  {visible(d.message)}"]
    lines += _excerpts(d, sources, tint if colour else "", width)
    if d.hint:
        lines.append(f"  {_paint('help:', BLUE + BOLD, colour)} {visible(d.hint)}")
    return "\n".join(lines) + "\n"


def _excerpts(
    d: Diagnostic, sources: Mapping[str, Source], tint: str, width: int | None
) -> list[str]:
    """Returns the lines of the diagnostic and of its labels, each file on its own, in order."""
    marks: dict[str, list[Mark]] = {}
    elsewhere = []
    places = [(d.span, "^", ""), *((label.span, "-", label.text) for label in d.labels)]
    for span, sign, text in places:
        if span.file in sources:
            marks.setdefault(span.file, []).extend(_marks(span, sources[span.file], sign, text))
        elif sign == "-":
            elsewhere.append(f"  {visible(span.file)}:{span.line}: {visible(text)}")
    digits = max((len(str(m.line)) for of_file in marks.values() for m in of_file), default=1)
    lines = []
    for file, of_file in marks.items():
        if file != d.span.file:
            first = of_file[0]
            arrow = f"{' ' * digits}-->"
            lines.append(f"  {arrow} {visible(file)}:{first.line}:{first.start + 1}")
        lines += _excerpt(sources[file], of_file, digits, tint, width)
    return lines + elsewhere


def _marks(span: Span, source: Source, sign: str, text: str) -> list[Mark]:
    """Returns a mark for each line of a span, the text beside the last one.

    Of many lines it returns only the first and the last.
    """
    end = source.span(span.end, span.end)
    last = end.line if end.column > 1 or end.line == span.line else end.line - 1
    marks = []
    for line in range(span.line, last + 1):
        content = source.line(line)
        start = span.column - 1 if line == span.line else len(content) - len(content.lstrip())
        stop = end.column - 1 if line == end.line else len(content.rstrip())
        if line == span.line or stop > start:
            marks.append(Mark(line, start, max(stop, start), sign))
    if len(marks) > LINES:
        marks = [marks[0], marks[-1]]
    return [*marks[:-1], replace(marks[-1], text=text)]


def _excerpt(
    source: Source, marks: list[Mark], digits: int, tint: str, width: int | None
) -> list[str]:
    """Returns the marked lines of a file with the marks below them.

    Args:
      digits: of the line numbers.
      tint: the colour of the marks of the mistake; "": no colours.
      width: of the terminal, in columns.
    """
    bar = " " * digits + " |"
    room = WIDTH if width is None else max(width - len(f"  {bar} "), NARROWEST)
    lines = [f"  {bar}"]
    before = 0
    for line in sorted({mark.line for mark in marks}):
        if before and line > before + 1:
            lines.append(f"  {'.' * max(digits, 3)}")
        of_line = [mark for mark in marks if mark.line == line]
        of_line.sort(key=lambda mark: (mark.start, mark.sign == "-"))
        content, columns = _cut(source.line(line), of_line, room)
        lines.append(f"  {line:>{digits}} | {content}".rstrip())
        for mark in of_line:
            start = columns[min(mark.start, len(columns) - 1)]
            end = columns[min(mark.end, len(columns) - 1)]
            marked = f"{mark.sign * max(1, end - start)} {visible(mark.text)}".rstrip()
            if tint:
                marked = f"{tint if mark.sign == '^' else BLUE}{marked}{PLAIN}"
            lines.append(f"  {bar} {' ' * start}{marked}")
        before = line
    return lines


def _cut(line: str, marks: list[Mark], room: int) -> tuple[str, list[int]]:
    """Returns a line as shown, at most `room` columns wide, and the column in which each of its
    characters begins, and in which the line ends.

    Of a long line it shows the part around the marks.
    """
    first = min(mark.start for mark in marks)
    last = min(max(mark.end for mark in marks), len(line))
    near = line[: last + room + 1]  # what follows isn't shown, and may be megabytes
    texts, columns = _in_columns(near)
    if near == line and columns[-1] <= room:
        return "".join(texts), columns
    begin = 0
    if columns[last] > room - 1:  # the last column is for an ellipsis
        begin = bisect_left(columns, min(columns[first] - BEFORE, columns[-1] - room + 1))
    left = "…" if begin else ""
    right_edge = columns[begin] + room - len(left)
    end = len(near)
    if columns[end] > right_edge:
        end = bisect_right(columns, right_edge - 1) - 1
    right = "…" if end < len(line) else ""
    shift = len(left) - columns[begin]
    shown_columns = [min(max(column, columns[begin]), columns[end]) + shift for column in columns]
    return f"{left}{''.join(texts[begin:end])}{right}", shown_columns


def _in_columns(line: str) -> tuple[list[str], list[int]]:
    """Returns what is shown for each character of a line, and the columns in which the characters
    and the end of the line are.

    A tab goes on to the next multiple of `TAB`; East Asian wide characters and most emoji take two
    columns, and marks that combine with the character before them take none.
    """
    texts = []
    columns = [0]
    for character in line:
        column = columns[-1]
        if character == "\t":
            text = " " * (TAB - column % TAB)
        else:
            text = _visible_character(character)
        texts.append(text)
        columns.append(column + sum(map(_columns_of, text)))
    return texts, columns


def _columns_of(character: str) -> int:
    """Returns how many columns of a terminal a printable character takes."""
    if unicodedata.combining(character) or unicodedata.category(character) in ("Mn", "Me"):
        return 0
    return 2 if unicodedata.east_asian_width(character) in "WF" else 1


def visible(text: str) -> str:
    """Returns a text with everything unprintable escaped."""
    return "".join(map(_visible_character, text))


def _visible_character(character: str) -> str:
    if character.isprintable():
        return character
    code = ord(character)
    return f"\\x{code:02x}" if code < 256 else f"\\u{code:04x}"


def _paint(text: str, tint: str, colour: bool) -> str:
    """Returns a text in a colour, or as it is without colours."""
    return f"{tint}{text}{PLAIN}" if colour else text

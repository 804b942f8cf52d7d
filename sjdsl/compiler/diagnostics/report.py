"""Prints diagnostics: as text with the lines they are about, or as plain data for a program."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from sjdsl.compiler.diagnostics.diagnostic import Diagnostic
from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.diagnostics.source import Source, Span

WIDTH = 100  # columns of an excerpt; a longer line is cut around what the message is about
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


def render(diagnostics: Sequence[Diagnostic], sources: Mapping[str, Source], colour: bool) -> str:
    """Returns the diagnostics as text for a terminal, with the number of errors and warnings."""
    if not diagnostics:
        return ""
    parts = [_render_one(d, sources, colour) for d in diagnostics]
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


def _render_one(d: Diagnostic, sources: Mapping[str, Source], colour: bool) -> str:
    """Returns a diagnostic as text: its message, the lines it is about, and its help."""
    tint = RED if d.severity == "error" else YELLOW
    head = _paint(f"{d.severity}[{d.code}]", tint + BOLD, colour)
    place = f"{visible(d.span.file)}:{d.span.line}:{d.span.column}"
    lines = [f"{head} {_paint(place, BOLD, colour)}", f"  {visible(d.message)}"]
    lines += _excerpts(d, sources, tint if colour else "")
    if d.hint:
        lines.append(f"  {_paint('help:', BLUE + BOLD, colour)} {visible(d.hint)}")
    return "\n".join(lines) + "\n"


def _excerpts(d: Diagnostic, sources: Mapping[str, Source], tint: str) -> list[str]:
    """Returns the lines of the diagnostic and of its labels, each file on its own, in order."""
    marks: dict[str, list[Mark]] = {}
    elsewhere = []
    places = [(d.span, "^", ""), *((label.span, "-", label.text) for label in d.labels)]
    for span, sign, text in places:
        if span.file in sources:
            marks.setdefault(span.file, []).extend(_marks(span, sources[span.file], sign, text))
        elif sign == "-":
            elsewhere.append(f"  {visible(span.file)}:{span.line}: {visible(text)}")
    width = max((len(str(m.line)) for of_file in marks.values() for m in of_file), default=1)
    lines = []
    for file, of_file in marks.items():
        if file != d.span.file:
            first = of_file[0]
            arrow = f"{' ' * width}-->"
            lines.append(f"  {arrow} {visible(file)}:{first.line}:{first.start + 1}")
        lines += _excerpt(sources[file], of_file, width, tint)
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


def _excerpt(source: Source, marks: list[Mark], width: int, tint: str) -> list[str]:
    """Returns the marked lines of a file with the marks below them.

    Args:
      width: of the line numbers.
      tint: the colour of the marks of the mistake; "": no colours.
    """
    bar = " " * width + " |"
    lines = [f"  {bar}"]
    before = 0
    for line in sorted({mark.line for mark in marks}):
        if before and line > before + 1:
            lines.append(f"  {'.' * max(width, 3)}")
        of_line = [mark for mark in marks if mark.line == line]
        of_line.sort(key=lambda mark: (mark.start, mark.sign == "-"))
        content, columns = _cut(source.line(line), of_line)
        lines.append(f"  {line:>{width}} | {content}".rstrip())
        for mark in of_line:
            start = columns[min(mark.start, len(columns) - 1)]
            end = columns[min(mark.end, len(columns) - 1)]
            marked = f"{mark.sign * max(1, end - start)} {visible(mark.text)}".rstrip()
            if tint:
                marked = f"{tint if mark.sign == '^' else BLUE}{marked}{PLAIN}"
            lines.append(f"  {bar} {' ' * start}{marked}")
        before = line
    return lines


def _cut(line: str, marks: list[Mark]) -> tuple[str, list[int]]:
    """Returns a line as shown, and the column of each of its characters and of its end.

    Of a long line it shows the part around the marks.
    """
    begin = 0
    end = len(line)
    if len(line) > WIDTH:
        first = min(mark.start for mark in marks)
        last = max(mark.end for mark in marks)
        if last > WIDTH - 2:
            begin = max(0, min(first - 20, len(line) - WIDTH + 2))
        end = begin + WIDTH - 2
    shown = "…" if begin else ""
    columns = [0] * begin
    for character in line[begin:end]:
        columns.append(len(shown))
        if character == "\t":
            shown += " " * (TAB - len(shown) % TAB)
        else:
            shown += visible(character)
    if end < len(line):
        shown += "…"
    return shown, columns + [len(shown)] * (len(line) - end + 1)


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

"""Prints diagnostics: as text with the lines they are about, or as plain data for a program."""

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

from sjdsl.compiler.diagnostics.diagnostic import Diagnostic
from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.diagnostics.source import Source, Span

WIDTH = 100  # columns of an excerpt; a longer line is cut around what the message is about
TAB = 4
LINES = 4  # a longer span shows its first and last line only
RED, YELLOW, BLUE, BOLD, PLAIN = "\x1b[31m", "\x1b[33m", "\x1b[34m", "\x1b[1m", "\x1b[0m"


class Mark(Record):
    """The part `start .. end` of one line, in characters from 0, with its sign and what to say beside it."""

    line: int
    start: int
    end: int
    sign: str
    text: str = ""


def render(diagnostics: Sequence[Diagnostic], sources: Mapping[str, Source], colour: bool) -> str:
    """Returns the diagnostics as text for a terminal, the number of errors and warnings at its end."""
    parts = [_render_one(d, sources, colour) for d in diagnostics]
    counts = Counter(d.severity for d in diagnostics)
    counted = [
        f"{counts[name]} {name}{'s' * (counts[name] > 1)}"
        for name in ("error", "warning")
        if name in counts
    ]
    return "\n".join([*parts, ", ".join(counted)]) if parts else ""


def to_json(
    diagnostics: Sequence[Diagnostic], sources: Mapping[str, Source] | None = None
) -> list[dict[str, Any]]:
    """Returns the diagnostics as plain data; without its text, a span is taken to end in the line it begins in."""
    return [
        {
            "code": d.code,
            "severity": d.severity,
            "message": d.message,
            "hint": d.hint,
            **_place(d.span, sources or {}),
            "labels": [
                {"text": label.text, **_place(label.span, sources or {})} for label in d.labels
            ],
            "fix": {"text": d.fix.text, **_place(d.fix.span, sources or {})} if d.fix else None,
        }
        for d in diagnostics
    ]


def _place(span: Span, sources: Mapping[str, Source]) -> dict[str, Any]:
    """Returns a span as JSON."""
    line, column = span.line, span.column + span.end - span.start
    if span.file in sources:
        end = sources[span.file].span(span.end, span.end)
        line, column = end.line, end.column
    return {
        "file": span.file,
        "line": span.line,
        "column": span.column,
        "end_line": line,
        "end_column": column,
    }


def _render_one(d: Diagnostic, sources: Mapping[str, Source], colour: bool) -> str:
    tint = RED if d.severity == "error" else YELLOW
    head = _paint(f"{d.severity}[{d.code}]", tint + BOLD, colour)
    where = f"{visible(d.span.file)}:{d.span.line}:{d.span.column}"
    lines = [f"{head} {_paint(where, BOLD, colour)}", f"  {visible(d.message)}"]
    lines += _excerpts(d, sources, tint if colour else "")
    if d.hint:
        lines.append(f"  {_paint('help:', BLUE + BOLD, colour)} {visible(d.hint)}")
    return "\n".join(lines) + "\n"


def _excerpts(d: Diagnostic, sources: Mapping[str, Source], tint: str) -> list[str]:
    """The lines of the diagnostic and of its labels, each file on its own, in order."""
    marks: dict[str, list[Mark]] = {}
    places = [(d.span, "^", "")] + [(label.span, "-", label.text) for label in d.labels]
    for span, sign, text in places:
        if span.file in sources:
            marks.setdefault(span.file, []).extend(_marks(span, sources[span.file], sign, text))
    width = max((len(str(m.line)) for per_file in marks.values() for m in per_file), default=1)
    lines = []
    for file, per_file in marks.items():
        if file != d.span.file:
            lines.append(
                f"  {' ' * width}--> {visible(file)}:{per_file[0].line}:{per_file[0].start + 1}"
            )
        lines += _excerpt(sources[file], per_file, width, tint)
    unseen = [label for label in d.labels if label.span.file not in sources]
    return lines + [
        f"  {visible(label.span.file)}:{label.span.line}: {visible(label.text)}" for label in unseen
    ]


def _marks(span: Span, source: Source, sign: str, text: str) -> list[Mark]:
    """Splits a span into its lines; of many lines the first and the last, the words beside the last."""
    end = source.span(span.end, span.end)
    last = end.line if end.column > 1 or end.line == span.line else end.line - 1
    marks = []
    for line in range(span.line, last + 1):
        content = source.line(line)
        start = span.column - 1 if line == span.line else len(content) - len(content.lstrip())
        stop = end.column - 1 if line == end.line else len(content.rstrip())
        if line == span.line or stop > start:
            marks.append(Mark(line, start, max(stop, start), sign))
    marks = marks if len(marks) <= LINES else [marks[0], marks[-1]]
    final = marks[-1]
    return [*marks[:-1], Mark(final.line, final.start, final.end, sign, text)]


def _excerpt(source: Source, marks: list[Mark], width: int, tint: str) -> list[str]:
    bar = " " * width + " |"
    lines, before = [f"  {bar}"], 0
    for line in sorted({mark.line for mark in marks}):
        if before and line > before + 1:
            lines.append(f"  {'.' * max(width, 3)}")
        here = sorted((m for m in marks if m.line == line), key=lambda m: (m.start, m.sign == "-"))
        content, columns = _cut(source.line(line), here)
        lines.append(f"  {line:>{width}} | {content}".rstrip())
        for mark in here:
            start, end = (columns[min(place, len(columns) - 1)] for place in (mark.start, mark.end))
            marked = f"{mark.sign * max(1, end - start)} {visible(mark.text)}".rstrip()
            marked = f"{tint if mark.sign == '^' else BLUE}{marked}{PLAIN}" if tint else marked
            lines.append(f"  {bar} {' ' * start}{marked}")
        before = line
    return lines


def _cut(line: str, marks: list[Mark]) -> tuple[str, list[int]]:
    """Returns the line as shown, of a long one the part around the marks, and for each of its characters and its end the column where it is."""
    first, last = min(m.start for m in marks), max(m.end for m in marks)
    begin = (
        0
        if len(line) <= WIDTH or last <= WIDTH - 2
        else max(0, min(first - 20, len(line) - WIDTH + 2))
    )
    end = len(line) if len(line) <= WIDTH else begin + WIDTH - 2
    shown, columns = "…" * (begin > 0), [0] * begin
    for character in line[begin:end]:
        columns.append(len(shown))
        shown += " " * (TAB - len(shown) % TAB) if character == "\t" else visible(character)
    shown += "…" * (end < len(line))
    return shown, columns + [len(shown)] * (len(line) - end + 1)


def visible(text: str) -> str:
    """Returns a text with everything unprintable escaped."""
    return "".join(
        c if c.isprintable() else f"\\x{ord(c):02x}" if ord(c) < 256 else f"\\u{ord(c):04x}"
        for c in text
    )


def _paint(text: str, tint: str, colour: bool) -> str:
    return f"{tint}{text}{PLAIN}" if colour else text

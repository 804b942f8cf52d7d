"""Elaborates the map: text in the game or in a file beside it; refuses ragged rows and unknown glyphs."""

import errno
import re
import unicodedata
from collections import Counter
from collections.abc import Iterable
from pathlib import Path

from sjdsl.compiler import ast, ir
from sjdsl.compiler.diagnostics import errors, limits
from sjdsl.compiler.diagnostics.diagnostic import Label, Near
from sjdsl.compiler.diagnostics.problems import Problems
from sjdsl.compiler.diagnostics.source import Source, Span
from sjdsl.compiler.elaborate.scope import Static
from sjdsl.compiler.syntax.read import inside_folder
from sjdsl.files import read_bytes
from sjdsl.near_names import nearest

MAX_MAP_BYTES = 4 * limits.MAX_MAP_CELLS
POSES = "^>v<"  # how agents are drawn, by their heading
TOO_MANY_CELLS = f"it has more than {limits.MAX_MAP_CELLS} cells"
Rows = tuple[
    tuple[str, ...], tuple[Span, ...]
]  # of a map in a file of its own: each row, and where it stands there


def read_rows(map_: ast.Map, source: Source, problems: Problems) -> Rows:
    """Returns the rows of a map; one that cannot be read has none, and the reason is reported. Rows in the game itself have no spans."""
    if map_.file is None:
        return tuple(row.text for row in map_.rows), ()
    name, span = map_.file.text, map_.file.span
    path = inside_folder(name, span, source, problems)
    if path is None:
        return (), ()
    name_here = (Path(source.name).parent / name).as_posix()
    over = source.instead_of(path)
    if over is not None:
        return _parse_rows(over.encode("utf-8", "replace"), name_here, span, problems)
    if path.exists():
        return parse_file(path, name_here, span, problems)
    meant = nearest(
        path.name, [p.name for p in path.parent.iterdir()] if path.parent.is_dir() else []
    )
    problems.add(
        errors.NoFile(
            span, name=name, near=Near(tuple(str(Path(name).with_name(one)) for one in meant))
        )
    )
    return (), ()


def parse_file(path: Path, name: str, span: Span, problems: Problems) -> Rows:
    """Returns the rows of a map file, of which no more is read than a map may have.

    name: of the file, as messages call it. span: what names the file, to say there that it cannot be read.
    """
    try:
        data = read_bytes(path, MAX_MAP_BYTES)
    except OSError as error:
        problem = (
            TOO_MANY_CELLS
            if error.errno == errno.EFBIG
            else f"it cannot be read: {(error.strerror or 'unknown').lower()}"
        )
        problems.add(errors.MapFile(span, name=name, problem=problem))
        return (), ()
    return _parse_rows(data, name, span, problems)


def _parse_rows(data: bytes, name: str, span: Span, problems: Problems) -> Rows:
    text, problem = "", ""
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        problem = "it is not text"
    if len(data) > MAX_MAP_BYTES:
        problem = TOO_MANY_CELLS
    elif re.match(r"sj \d", text):
        problem = "it is a game"
    if problem:
        problems.add(errors.MapFile(span, name=name, problem=problem))
        return (), ()
    lines = text.rstrip("\r\n").split("\n") if text.strip() else []
    return tuple(line.rstrip("\r") for line in lines), row_spans(lines, name)


def row_spans(lines: Iterable[str], name: str) -> tuple[Span, ...]:
    """Returns where each line of a map stands in its file, without the line's end; of a map without lines, the file's beginning."""
    spans, start = [], 0
    for number, line in enumerate(lines, 1):
        spans.append(Span(name, start, start + len(line.rstrip("\r")), number, 1))
        start += len(line) + 1
    return tuple(spans) or (Span(name, 0, 0, 1, 1),)


def check_glyph(glyph: str) -> str:
    """Returns what is wrong with a glyph, or nothing."""
    if len(glyph) != 1:
        return "it is not one character"
    if not glyph.isascii() or not glyph.isprintable():
        return f"it is {unicodedata.name(glyph, 'a control character').lower()}"
    return "it is a blank" if glyph == " " else ""


def check_rows(
    given: Rows,
    glyphs: dict[str, ir.GlyphMeaning],
    span: Span,
    problems: Problems,
    inline: tuple[ast.String, ...] = (),
) -> bool:
    """Reports ragged rows, unknown glyphs and maps beyond the limits; returns whether the map is sound.

    `span`: the map as a whole; `inline`: the rows as written in the game, to point at the very place.
    """
    rows, spans = given
    span = spans[0] if spans else span
    if not rows or not rows[0]:
        problems.add(errors.EmptyMap(span))
        return False
    widths = [len(row) for row in rows]
    wanted = max(set(widths), key=widths.count)
    sound = True
    if len(rows) > limits.MAX_MAP_SIDE or wanted > limits.MAX_MAP_SIDE:
        what = f"a map of {len(rows)} x {wanted} cells (at most {limits.MAX_MAP_SIDE} x {limits.MAX_MAP_SIDE})"
        problems.add(errors.Unsupported(span, feature=what))
        return False
    for number, row in enumerate(rows):
        if len(row) != wanted:
            problems.add(
                errors.RaggedMap(
                    _place(inline, spans, number, None, span),
                    row=number,
                    length=len(row),
                    wanted=wanted,
                )
            )
            sound = False
    unknown: dict[str, tuple[int, int]] = {}
    for number, row in enumerate(rows):
        for column, glyph in enumerate(row):
            if glyph not in glyphs:
                unknown.setdefault(glyph, (number, column))
    # the place of the one glyph that is declared and nowhere on the map: perhaps it is the one that is misspelt
    absent = [
        m
        for m in glyphs.values()
        if m.origin is not None and not any(m.glyph in row for row in rows)
    ]
    labels = tuple(
        Label(m.span, f"`{m.glyph}` is nowhere on the map") for m in absent if len(absent) == 1
    )
    for glyph, (number, column) in list(unknown.items())[:20]:
        other_case = glyph.swapcase() if glyph.swapcase() in glyphs else ""
        shown = glyph if glyph.isprintable() else f"\\x{ord(glyph):02x}"
        place = _place(inline, spans, number, column, span)
        problems.add(
            errors.UnknownGlyph(
                place, labels=labels, glyph=shown, row=number, column=column, other_case=other_case
            )
        )
    return sound and not unknown


def _place(
    inline: tuple[ast.String, ...],
    spans: tuple[Span, ...],
    row: int,
    column: int | None,
    span: Span,
) -> Span:
    """Returns the span of a row, or of one glyph of it, in the map's own file or in the game's text."""
    if row < len(spans):
        whole, before = spans[row], 0
    elif row < len(inline):
        whole, before = inline[row].span, 1  # a quote
        if (
            whole.end - whole.start != len(inline[row].text) + 2
        ):  # something is escaped: characters do not stand where they seem to
            return whole
    else:
        return span
    if column is None:
        return whole
    start = whole.start + before + column
    return Span(whole.file, start, start + 1, whole.line, whole.column + before + column)


def count_cells(rows: tuple[str, ...], glyphs: dict[str, ir.GlyphMeaning]) -> dict[str, int]:
    """Returns the number of cells of each kind."""
    return dict(Counter(glyphs[glyph].kind for row in rows for glyph in row if glyph in glyphs))


def glyph_table(static: Static, problems: Problems) -> dict[str, ir.GlyphMeaning]:
    """Returns the legend; reports a glyph of two kinds, and one that can't be a glyph."""
    table: dict[str, ir.GlyphMeaning] = {}
    for span, meaning in static.glyphs:
        problem = check_glyph(meaning.glyph)
        if problem:
            shown = meaning.glyph.encode("unicode_escape").decode()
            problems.add(errors.BadGlyph(span, glyph=shown, problem=problem))
        elif meaning.glyph in table:
            first = table[meaning.glyph].kind
            there = table[meaning.glyph].origin
            labels = (Label(there, f"of `{first}` here"),) if there is not None else ()
            problems.add(
                errors.GlyphTwice(
                    span, labels=labels, glyph=meaning.glyph, first=first, second=meaning.kind
                )
            )
        else:
            table[meaning.glyph] = meaning
            if meaning.glyph in POSES:
                problems.add(errors.GlyphOfAgents(span, glyph=meaning.glyph))
    assert all(m.kind in static.kinds for m in table.values())
    return table

"""Elaborates the map, in the game or in a file: no ragged rows, no unknown glyphs."""

import errno
import re
import unicodedata
from collections import Counter
from collections.abc import Iterable
from itertools import islice
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
MOST_UNKNOWN = 20  # glyphs that are reported
POSES = "^>v<"  # how agents are drawn, by their heading
TOO_MANY_CELLS = f"it has more than {limits.MAX_MAP_CELLS} cells"
Rows = tuple[tuple[str, ...], tuple[Span, ...]]  # of a map; for a map in a file, where each stands


def read_rows(map_: ast.Map, source: Source, problems: Problems) -> Rows:
    """Returns the rows of a map; none for one that cannot be read, which is reported.

    Rows in the game itself have no spans.
    """
    if map_.file is None:
        return tuple(row.text for row in map_.rows), ()
    name = map_.file.text
    span = map_.file.span
    path = inside_folder(name, span, source, problems)
    if path is None:
        return (), ()
    shown_name = (Path(source.name).parent / name).as_posix()
    unsaved = source.instead_of(path)
    if unsaved is not None:
        return _parse_rows(unsaved.encode("utf-8", "replace"), shown_name, span, problems)
    if path.exists():
        return parse_file(path, shown_name, span, problems)
    siblings = [p.name for p in path.parent.iterdir()] if path.parent.is_dir() else []
    similar = nearest(path.name, siblings)
    near = Near(tuple(str(Path(name).with_name(sibling)) for sibling in similar))
    problems.add(errors.NoFile(span, name=name, near=near))
    return (), ()


def parse_file(path: Path, name: str, span: Span, problems: Problems) -> Rows:
    """Returns the rows of a map file, of which no more is read than a map may have.

    name: of the file, for messages. span: what names the file, where problems are reported.
    """
    try:
        data = read_bytes(path, MAX_MAP_BYTES)
    except OSError as error:
        problem = TOO_MANY_CELLS
        if error.errno != errno.EFBIG:
            problem = f"it cannot be read: {(error.strerror or 'unknown').lower()}"
        problems.add(errors.MapFile(span, name=name, problem=problem))
        return (), ()
    return _parse_rows(data, name, span, problems)


def _parse_rows(data: bytes, name: str, span: Span, problems: Problems) -> Rows:
    """Returns the rows of a map file and their spans; none for one that is no map."""
    text = ""
    problem = ""
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
    """Returns where each line of a map stands in its file, without the line's end.

    For a map without lines it returns the file's beginning.
    """
    spans = []
    start = 0
    for number, line in enumerate(lines, 1):
        end = start + len(line.rstrip("\r"))
        spans.append(Span(name, start, end, number, 1))
        start += len(line) + 1
    return tuple(spans) or (Span(name, 0, 0, 1, 1),)


def check_glyph(glyph: str) -> str:
    """Returns why a text can't be a glyph, empty if it can."""
    if len(glyph) != 1:
        return "it is not one character"
    if not glyph.isascii() or not glyph.isprintable():
        return f"it is {unicodedata.name(glyph, 'a control character').lower()}"
    return "it is a blank" if glyph == " " else ""


def check_rows(
    rows_and_spans: Rows,
    glyphs: dict[str, ir.GlyphMeaning],
    span: Span,
    problems: Problems,
    inline: tuple[ast.String, ...] = (),
) -> bool:
    """Returns whether a map is sound; reports ragged rows, unknown glyphs and maps too large.

    span: the map as a whole. inline: the rows as written in the game, to point at the very place.
    """
    rows, spans = rows_and_spans
    span = spans[0] if spans else span
    if not rows or not rows[0]:
        problems.add(errors.EmptyMap(span))
        return False
    widths = [len(row) for row in rows]
    width = max(set(widths), key=widths.count)
    side = limits.MAX_MAP_SIDE
    if len(rows) > side or width > side:
        feature = f"a map of {len(rows)} x {width} cells (at most {side} x {side})"
        problems.add(errors.Unsupported(span, feature=feature))
        return False

    def place(row: int, column: int | None) -> Span:
        return _place(inline, spans, row, column) or span

    for number, row in enumerate(rows):
        if len(row) != width:
            problems.add(
                errors.RaggedMap(place(number, None), row=number, length=len(row), wanted=width)
            )
    unknown: dict[str, tuple[int, int]] = {}
    for number, row in enumerate(rows):
        for column, glyph in enumerate(row):
            if glyph not in glyphs:
                unknown.setdefault(glyph, (number, column))
    labels = _label_of_absent(rows, glyphs)
    for glyph, (number, column) in islice(unknown.items(), MOST_UNKNOWN):
        problems.add(
            errors.UnknownGlyph(
                place(number, column),
                labels=labels,
                glyph=glyph if glyph.isprintable() else f"\\x{ord(glyph):02x}",
                row=number,
                column=column,
                other_case=glyph.swapcase() if glyph.swapcase() in glyphs else "",
            )
        )
    return not unknown and set(widths) == {width}


def _label_of_absent(
    rows: tuple[str, ...], glyphs: dict[str, ir.GlyphMeaning]
) -> tuple[Label, ...]:
    """Returns a label for the one glyph that is declared and nowhere on the map.

    If a glyph of the map is unknown, the declaration may be what is misspelt.
    """
    on_map = set().union(*rows)
    absent = [m for m in glyphs.values() if m.origin is not None and m.glyph not in on_map]
    if len(absent) != 1:
        return ()
    return (Label(absent[0].span, f"`{absent[0].glyph}` is nowhere on the map"),)


def _place(
    inline: tuple[ast.String, ...], spans: tuple[Span, ...], row: int, column: int | None
) -> Span | None:
    """Returns where a row, or one glyph of it, is written: in the map's file or in the game."""
    if row < len(spans):
        whole = spans[row]
        offset = 0
    elif row < len(inline):
        whole = inline[row].span
        offset = 1  # after a quote
        has_escapes = whole.end - whole.start != len(inline[row].text) + 2
        if has_escapes:  # characters are not where they seem to be
            return whole
    else:
        return None
    if column is None:
        return whole
    start = whole.start + offset + column
    return Span(whole.file, start, start + 1, whole.line, whole.column + offset + column)


def count_cells(rows: tuple[str, ...], glyphs: dict[str, ir.GlyphMeaning]) -> dict[str, int]:
    """Returns the number of cells of each kind."""
    cells = "".join(rows)
    return dict(Counter(glyphs[glyph].kind for glyph in cells if glyph in glyphs))


def glyph_table(static: Static, problems: Problems) -> dict[str, ir.GlyphMeaning]:
    """Returns the legend; reports a glyph of two kinds, and one that can't be a glyph."""
    table: dict[str, ir.GlyphMeaning] = {}
    for span, meaning in static.glyphs:
        glyph = meaning.glyph
        problem = check_glyph(glyph)
        first = table.get(glyph)
        if problem:
            shown = glyph.encode("unicode_escape").decode()
            problems.add(errors.BadGlyph(span, glyph=shown, problem=problem))
        elif first is not None:
            labels: tuple[Label, ...] = ()
            if first.origin is not None:
                labels = (Label(first.origin, f"of `{first.kind}` here"),)
            problems.add(
                errors.GlyphTwice(
                    span, labels=labels, glyph=glyph, first=first.kind, second=meaning.kind
                )
            )
        else:
            table[glyph] = meaning
            if glyph in POSES:
                problems.add(errors.GlyphOfAgents(span, glyph=glyph))
    assert all(m.kind in static.kinds for m in table.values())
    return table

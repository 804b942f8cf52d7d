"""Changes of the text that are made beside it: another glyph on a cell of the map, another value of a number."""

from dataclasses import dataclass
from pathlib import PurePosixPath

from sjdsl.compiler import ast
from sjdsl.studio.opened import Opened


class CannotPaint(Exception):
    """The map, or a number, cannot be changed here; the text says why, and what to do."""


@dataclass(frozen=True)
class Change:
    """Replaces the characters `start .. end` of a text by `glyph`, or by the text of a number; both counted in UTF-16 units as browsers do.

    path: of the game or of its map's file, in the folder; before: what stands there now.
    """

    path: str
    start: int
    end: int
    before: str
    glyph: str


def map_file(opened: Opened) -> str | None:
    """Returns the path of the file that has the map, None if the map is written in a game."""
    written = opened.composition.map
    if written is None or written.file is None:
        return None
    return (PurePosixPath(opened.source.name).parent / written.file.text).as_posix()


def glyphs(opened: Opened) -> list[tuple[str, str]]:
    """Returns each glyph of the map with what it stands for: a kind, and values that are not as declared."""
    starts = [
        (meaning, ", ".join(f"{name} {value}" for name, value in meaning.starts))
        for meaning in opened.game.glyphs
    ]
    return [
        (meaning.glyph, f"{meaning.kind}: {values}" if values else meaning.kind)
        for meaning, values in starts
    ]


def paint(opened: Opened, row: int, col: int, glyph: str) -> Change:
    """Returns the change that puts a glyph on a cell. Raises CannotPaint."""
    game, written = opened.game, opened.composition.map
    if glyph not in {meaning.glyph for meaning in game.glyphs}:
        raise CannotPaint(f"no kind of this game has the glyph `{glyph}`")
    if written is None or not (0 <= row < len(game.rows) and 0 <= col < len(game.rows[0])):
        raise CannotPaint("that is no cell of the map")
    before = game.rows[row][col]
    path = map_file(opened)
    if path is not None:
        start = _units("\n".join((*game.rows[:row], game.rows[row][:col])))
        return Change(path, start, start + _units(before), before, glyph)
    line = written.rows[row]
    if line.span.file != opened.source.name:
        raise CannotPaint(
            f"the map is written in `{PurePosixPath(line.span.file).name}`, which this game extends: open that one"
        )
    text, at = opened.source.text, line.span.start + 1 + col
    if text[at] != before or text[line.span.start + 1 : line.span.end - 1] != line.text:
        raise CannotPaint("this row of the map is written with escapes: change it in the text")
    start = _units(text[:at])
    return Change(opened.source.name, start, start + _units(before), before, glyph)


def write_number(opened: Opened, name: str, entry: tuple[str, ...], value: str) -> Change:
    """Returns the change that writes a value where the text, in its chosen variant, has that of a param. Raises CannotPaint.

    entry: keys of one entry of a table, outermost first; none of a param that is no table. value: as it will stand in the text.
    """
    constant = opened.composition.constants.get(name)
    if constant is None:
        raise CannotPaint(f"the game has no number `{name}`")
    node = constant.value
    for key in entry:
        entries = {e.key.text: e.value for e in node.entries} if isinstance(node, ast.Table) else {}
        if key not in entries:
            raise CannotPaint(
                f"`{name}` has no entry of its own for {key}: it is written together with others, so change it in the text"
            )
        node = entries[key]
    span, text = node.span, opened.source.text
    if span.file != opened.source.name:
        raise CannotPaint(
            f"`{name}` is written in `{PurePosixPath(span.file).name}`, which this game extends: open that one"
        )
    start = _units(text[: span.start])
    before = text[span.start : span.end]
    return Change(opened.source.name, start, start + _units(before), before, value)


def _units(text: str) -> int:
    return len(text.encode("utf-16-le")) // 2

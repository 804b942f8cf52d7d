"""Changes of the text from the board and the panels: a glyph of the map, the value of a param."""

from dataclasses import dataclass
from pathlib import PurePosixPath

from sjdsl.compiler import ast
from sjdsl.studio.opened import Opened


class CannotPaint(Exception):
    """The map or a param can't be changed by the page; the message says why, and what to do."""


@dataclass(frozen=True)
class Change:
    """A replacement of the characters `start .. end` of a text.

    path: of the game or of its map, in the folder; start, end: in UTF-16 units, as browsers count.
    before: the characters now; glyph: the new ones, a glyph or a number.
    """

    path: str
    start: int
    end: int
    before: str
    glyph: str


def map_file(opened: Opened) -> str | None:
    """Returns the path of the map's file, None if the map stands in a game."""
    map_ = opened.composition.map
    if map_ is None or map_.file is None:
        return None
    return (PurePosixPath(opened.source.name).parent / map_.file.text).as_posix()


def glyphs(opened: Opened) -> list[tuple[str, str]]:
    """Returns each glyph with its kind, and the values that differ from the declared ones."""
    meanings = []
    for meaning in opened.game.glyphs:
        values = ", ".join(f"{name} {value}" for name, value in meaning.starts)
        meanings.append((meaning.glyph, f"{meaning.kind}: {values}" if values else meaning.kind))
    return meanings


def paint(opened: Opened, row: int, col: int, glyph: str) -> Change:
    """Returns the change that puts a glyph on a cell. Raises CannotPaint."""
    game = opened.game
    map_ = opened.composition.map
    if glyph not in {meaning.glyph for meaning in game.glyphs}:
        raise CannotPaint(f"no kind of this game has the glyph `{glyph}`")
    if map_ is None or not (0 <= row < len(game.rows) and 0 <= col < len(game.rows[0])):
        raise CannotPaint("that is no cell of the map")
    before = game.rows[row][col]
    path = map_file(opened)
    if path is not None:
        start = _units("\n".join((*game.rows[:row], game.rows[row][:col])))
        return Change(path, start, start + _units(before), before, glyph)
    line = map_.rows[row]
    if line.span.file != opened.source.name:
        raise CannotPaint(
            f"the map is written in `{PurePosixPath(line.span.file).name}`, which this game "
            "extends: open that one"
        )
    text = opened.source.text
    first = line.span.start + 1
    if text[first + col] != before or text[first : line.span.end - 1] != line.text:
        raise CannotPaint("this row of the map is written with escapes: change it in the text")
    start = _units(text[: first + col])
    return Change(opened.source.name, start, start + _units(before), before, glyph)


def write_number(opened: Opened, name: str, entry: tuple[str, ...], value: str) -> Change:
    """Returns the change of a param's value in the text, with the chosen variant.

    Args:
      entry: the keys of one entry, outermost first; none for a param that isn't indexed.
      value: as it will stand in the text.

    Raises:
      CannotPaint: the text has no such value.
    """
    constant = opened.composition.constants.get(name)
    if constant is None:
        raise CannotPaint(f"the game has no number `{name}`")
    node = constant.value
    for key in entry:
        entries = {e.key.text: e.value for e in node.entries} if isinstance(node, ast.Table) else {}
        if key not in entries:
            raise CannotPaint(
                f"`{name}` has no entry of its own for {key}: it is written together with others, "
                "so change it in the text"
            )
        node = entries[key]
    span = node.span
    if span.file != opened.source.name:
        raise CannotPaint(
            f"`{name}` is written in `{PurePosixPath(span.file).name}`, which this game extends: "
            "open that one"
        )
    text = opened.source.text
    start = _units(text[: span.start])
    before = text[span.start : span.end]
    return Change(opened.source.name, start, start + _units(before), before, value)


def _units(text: str) -> int:
    """Returns the number of UTF-16 units of a text."""
    return len(text.encode("utf-16-le")) // 2

"""Map files as sets of cells: where a glyph stands, what is connected, what lies near."""

from collections.abc import Iterable
from pathlib import Path

MAPS = Path(__file__).parents[2] / "games" / "maps"
Cell = tuple[int, int]
Cells = frozenset[Cell]


def read_map(game: str) -> tuple[str, ...]:
    """Returns the lines of a map, row 0 first."""
    return tuple((MAPS / f"{game}.txt").read_text(encoding="ascii").splitlines())


def find(game: str, glyphs: str) -> Cells:
    """Returns the (row, col) of every cell that shows one of `glyphs`."""
    rows = enumerate(read_map(game))
    return frozenset(
        (row, col) for row, line in rows for col, glyph in enumerate(line) if glyph in glyphs
    )


def box(rows: Iterable[int], cols: Iterable[int]) -> Cells:
    """Returns every cell in one of `rows` and one of `cols`."""
    columns = tuple(cols)
    return frozenset((row, col) for row in rows for col in columns)


def span(first: int, last: int) -> range:
    """Returns `first` to `last`, both included, as the tables below count."""
    return range(first, last + 1)


def region(cells: Cells, start: Cell, *, diagonal: bool = False) -> Cells:
    """Returns the cells that can be reached from `start` without leaving `cells`."""
    reached, waiting = {start}, [start]
    while waiting:
        row, col = waiting.pop()
        near = box(span(row - 1, row + 1), span(col - 1, col + 1))
        steps = near if diagonal else {(r, c) for r, c in near if r == row or c == col}
        fresh = (steps & cells) - reached
        reached |= fresh
        waiting += fresh
    return frozenset(reached)


def regions(cells: Cells, *, diagonal: bool = False) -> list[Cells]:
    """Returns the connected parts of `cells`, the topmost first."""
    parts: list[Cells] = []
    while left := cells.difference(*parts):
        parts.append(region(cells, min(left), diagonal=diagonal))
    return parts


def disc(centre: Cell, radius: int) -> Cells:
    """Returns the cells that are at most `radius` steps along rows and columns from `centre`, on the map or off."""
    row, col = centre
    around = box(span(row - radius, row + radius), span(col - radius, col + radius))
    return frozenset((r, c) for r, c in around if abs(r - row) + abs(c - col) <= radius)

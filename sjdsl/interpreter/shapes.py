"""Cells of a shape around an anchor, such as a beam.

Each lane ends at the first cell that blocks its line of sight.
"""

from collections.abc import Callable
from typing import NamedTuple

from sjdsl.compiler import ir
from sjdsl.interpreter.state import Cell

FORWARD = ((-1, 0), (0, 1), (1, 0), (0, -1))


class Seen(NamedTuple):
    """A cell of a shape with its number among the shape's cells, lane by lane."""

    cell: Cell
    number: int


def place_at(anchor: Cell, heading: int, ahead: int, right: int) -> tuple[int, int]:
    """Returns the row and column so many cells ahead and to the right of an anchor.

    They may be off the map.
    """
    ahead_rows, ahead_cols = FORWARD[heading]
    right_rows, right_cols = FORWARD[(heading + 1) % 4]
    row = anchor.row + ahead * ahead_rows + right * right_rows
    col = anchor.col + ahead * ahead_cols + right * right_cols
    return row, col


def lanes_from(
    shape: ir.Shape,
    anchor: Cell | None,
    heading: int,
    at: Callable[[int, int], Cell | None],
    stops: Callable[[Cell], bool],
) -> list[list[Seen]]:
    """Returns the lanes of a shape, nearest cell first.

    The first cell that `stops` a lane is its last. Lanes of an anchor that is off the map are
    empty. On a map that wraps, several places of the shape may be one cell: the first of them
    counts. The anchor's own cell counts only in the middle of the shape.

    Args:
      at: the cell of the map at a row and column, `Board.at`.
    """
    lanes: list[list[Seen]] = []
    visited = {anchor}
    number = 0
    for offsets in shape.lanes:
        lane: list[Seen] = []
        is_open = True
        for ahead, right in offsets:
            cell = None if anchor is None else at(*place_at(anchor, heading, ahead, right))
            if cell is not None and (cell not in visited or (ahead, right) == (0, 0)):
                visited.add(cell)
                if is_open:
                    lane.append(Seen(cell, number))
                    is_open = shape.see_through or not stops(cell)
            number += 1
        lanes.append(lane)
    return lanes


def num_places(shape: ir.Shape) -> int:
    """Returns the number of the shape's cells, on the map or not."""
    return sum(len(lane) for lane in shape.lanes)

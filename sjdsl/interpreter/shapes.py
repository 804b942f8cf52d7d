"""Cells of a shape around an anchor, such as a beam: each lane ends at the first cell that blocks its line of sight."""

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
    """Returns the row and column so far ahead and to the right of the anchor for somebody who faces `heading`; perhaps off the map."""
    forward, beside = FORWARD[heading], FORWARD[(heading + 1) % 4]
    return anchor.row + ahead * forward[0] + right * beside[0], anchor.col + ahead * forward[
        1
    ] + right * beside[1]


def lanes_from(
    shape: ir.Shape,
    anchor: Cell | None,
    heading: int,
    at: Callable[[int, int], Cell | None],
    stops: Callable[[Cell], bool],
) -> list[list[Seen]]:
    """Returns the shape's lanes as far as they go, nearest cell first; the cell that `stops` a lane is its last. Nothing from nowhere.

    at: the cell of the map at a row and column, `Board.at`. Places of the shape that are one cell of a map that wraps count once, as the
    first of them; the anchor's own cell counts only where the shape has its middle.
    """
    result: list[list[Seen]] = []
    met = {anchor}
    number = 0
    for offsets in shape.lanes:
        lane: list[Seen] = []
        open_ = True
        for ahead, right in offsets:
            cell = None if anchor is None else at(*place_at(anchor, heading, ahead, right))
            if cell is not None and (cell not in met or (ahead, right) == (0, 0)):
                met.add(cell)
                if open_:
                    lane.append(Seen(cell, number))
                    open_ = shape.see_through or not stops(cell)
            number += 1
        result.append(lane)
    return result


def size(shape: ir.Shape) -> int:
    """Returns the number of the shape's cells, on the map or not."""
    return sum(len(lane) for lane in shape.lanes)

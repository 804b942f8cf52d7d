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


def cell_at(anchor: Cell, heading: int, ahead: int, right: int) -> Cell:
    """Returns the cell so far ahead and to the right of the anchor for somebody who faces `heading`."""
    forward, beside = FORWARD[heading], FORWARD[(heading + 1) % 4]
    return Cell(anchor.row + ahead * forward[0] + right * beside[0], anchor.col + ahead * forward[1] + right * beside[1])


def lanes_from(
    shape: ir.Shape, anchor: Cell | None, heading: int, is_on_map: Callable[[Cell], bool], stops: Callable[[Cell], bool]
) -> list[list[Seen]]:
    """Returns the shape's lanes as far as they go, nearest cell first; the cell that `stops` a lane is its last. Nothing from nowhere."""
    result: list[list[Seen]] = []
    number = 0
    for offsets in shape.lanes:
        lane: list[Seen] = []
        open_ = True
        for ahead, right in offsets:
            if open_ and anchor is not None:
                cell = cell_at(anchor, heading, ahead, right)
                if is_on_map(cell):
                    lane.append(Seen(cell, number))
                    open_ = shape.see_through or not stops(cell)
            number += 1
        result.append(lane)
    return result


def size(shape: ir.Shape) -> int:
    """Returns the number of the shape's cells, on the map or not."""
    return sum(len(lane) for lane in shape.lanes)

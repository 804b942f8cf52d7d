"""Cells of a shape around an anchor, such as a beam: each lane ends at the first cell that blocks its line of sight."""

from typing import NamedTuple

from sjdsl.compiler import ir
from sjdsl.interpreter import evaluate
from sjdsl.interpreter.instance import Instance
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


def lanes(near: ir.Near, here: Instance) -> list[list[Seen]]:
    """Returns the shape's lanes as far as they go, nearest cell first; the cell that blocks a lane is its last."""
    shape = here.board.shapes[near.shape]
    anchor = here.names[near.anchor.name]
    agent = anchor if near.anchor.who == "agent" else None
    place = here.world.position[anchor] if near.anchor.who == "agent" else anchor
    heading = here.world.heading[agent] if shape.directed and agent is not None else 0
    result: list[list[Seen]] = []
    number = 0
    for offsets in shape.lanes:
        lane: list[Seen] = []
        open_ = True
        for ahead, right in offsets:
            if open_ and place is not None:
                cell = cell_at(place, heading, ahead, right)
                if cell in here.board.kind_of:
                    lane.append(Seen(cell, number))
                    open_ = shape.see_through or not is_blocked(cell, shape.name, agent, here)
            number += 1
        result.append(lane)
    return result


def cells_in(near: ir.Near, here: Instance) -> dict[Cell, int]:
    """Returns the cells of the shape with their numbers; a cell of two lanes has the first one's."""
    numbers: dict[Cell, int] = {}
    for lane in lanes(near, here):
        for cell, number in lane:
            numbers.setdefault(cell, number)
    return numbers


def size(shape: ir.Shape) -> int:
    """Returns the number of the shape's cells, on the map or not."""
    return sum(len(lane) for lane in shape.lanes)


def is_blocked(cell: Cell, what: str, agent: int | None, here: Instance) -> bool:
    """Returns whether the cell's kind blocks `what`: agents, or the shape of that name. `agent` moves, or is the anchor."""
    kind = here.board.kinds[here.board.kind_of[cell]]
    names = {kind.name: cell} if agent is None else {kind.name: cell, "agent": agent}
    return any(
        block.what == what and (block.condition is None or evaluate.evaluate(block.condition, here.only(names))) for block in kind.blocks
    )

"""From where agents reach which cells of a shape: tables of a map, for policies that aim."""

from collections.abc import Iterator

import numpy as np

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import blocks_always, kinds_by_glyph
from sjdsl.runtime.actions import DIRECTIONS


def visible_from(game: ir.Game, shape: ir.Shape, heading: int) -> Iterator[tuple[tuple[int, int], np.ndarray]]:
    """Yields each cell of a shape as seen with a heading, and from where it is not behind a cell that always blocks the shape.

    Yields:
      rows down and columns to the right of the agent, and `[H, W]` bool over the agent's cells.
    """
    kinds = kinds_by_glyph(game)
    stops = {kind.name for kind in game.kinds if blocks_always(kind, shape.name)}
    blocking = np.array([[kinds[glyph] in stops for glyph in row] for row in game.rows])
    (down, right), (down_beside, right_beside) = DIRECTIONS[heading], DIRECTIONS[(heading + 1) % 4]
    met = {(0, 0)}
    for lane in shape.lanes:
        free = np.ones(blocking.shape, bool)
        for ahead, beside in lane:
            offset = (ahead * down + beside * down_beside, ahead * right + beside * right_beside)
            place = (offset[0] % blocking.shape[0], offset[1] % blocking.shape[1])
            if game.wraps and place in met and offset != (0, 0):  # a cell of the shape already
                continue
            met.add(place)
            yield offset, free
            if not shape.see_through:
                free = free & ~_found_at(blocking, *offset, game.wraps)


def _found_at(cells: np.ndarray, rows: int, cols: int, wraps: bool) -> np.ndarray:
    """Returns for each cell of the map whether the cell so many rows down and columns to the right of it is one of `cells`."""
    if wraps:
        return np.roll(cells, (-rows, -cols), (0, 1))
    height, width = cells.shape
    found = np.zeros_like(cells)
    for row in range(max(0, -rows), min(height, height - rows)):
        for col in range(max(0, -cols), min(width, width - cols)):
            found[row, col] = cells[row + rows, col + cols]
    return found

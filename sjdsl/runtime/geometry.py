"""Static geometry: tables of a padded map, so that no window or shape leaves it, and where a beam ends at a wall (`lane_reach`).

A cell is its index in the padded frame, `(row + pad) * columns + column + pad`; cell 0, in the padding, is nowhere. Everything
here runs once, when a module is loaded, on NumPy arrays.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from sjdsl.runtime.actions import DIRECTIONS

Rows = Sequence[str]


def frame_size(rows: Rows, pad: int) -> tuple[int, int]:
    """Returns the rows and columns of the padded frame."""
    return len(rows) + 2 * pad, len(rows[0]) + 2 * pad


def cells_of(rows: Rows, pad: int, glyphs: str) -> np.ndarray:
    """Returns the cells with one of the glyphs in reading order: `[S]` int32."""
    columns = len(rows[0]) + 2 * pad
    found = [
        (r + pad) * columns + c + pad
        for r, row in enumerate(rows)
        for c, g in enumerate(row)
        if g in glyphs
    ]
    return np.array(found, np.int32)


def numbers_among(rows: Rows, group: str, glyphs: str) -> np.ndarray:
    """Returns the number, among the cells with one of `glyphs`, of each cell of a group, in reading order: `[S + 1]` int32.

    It is past their end for the other cells, and for the entry after the last cell.
    """
    chosen = np.array([g in glyphs for row in rows for g in row if g in group] + [False])
    return np.where(chosen, np.cumsum(chosen) - 1, chosen.sum()).astype(np.int32)


def reading_order(rows: Rows, kinds: Sequence[str]) -> np.ndarray:
    """Returns where each cell of a group, in reading order, stands if the cells of its kinds follow each other: `[S]` int32.

    Args:
      kinds: the glyphs of each kind.
    """
    kind_of = [
        number for row in rows for g in row for number, glyphs in enumerate(kinds) if g in glyphs
    ]
    return np.argsort(np.argsort(kind_of, kind="stable")).astype(np.int32)


def values_of(rows: Rows, values: Mapping[str, float], dtype: str) -> np.ndarray:
    """Returns the value of each cell whose glyph has one, in reading order: `[S]`."""
    return np.array([values[g] for row in rows for g in row if g in values], dtype)


def painted(rows: Rows, pad: int, values: Mapping[str, int]) -> np.ndarray:
    """Returns the frame with each glyph's value, 0 outside the map: `[cells]` uint8."""
    frame = np.zeros(frame_size(rows, pad), np.uint8)
    frame[pad : pad + len(rows), pad : pad + len(rows[0])] = [
        [values[g] for g in row] for row in rows
    ]
    return frame.reshape(-1)


def inside(rows: Rows, pad: int) -> np.ndarray:
    """Returns which cells of the frame are on the map: `[cells]` bool."""
    frame = np.zeros(frame_size(rows, pad), bool)
    frame[pad : pad + len(rows), pad : pad + len(rows[0])] = True
    return frame.reshape(-1)


def blocking(rows: Rows, pad: int, glyphs: str) -> np.ndarray:
    """Returns which cells of the frame have one of the glyphs: `[cells]` bool."""
    frame = np.zeros(frame_size(rows, pad)[0] * frame_size(rows, pad)[1], bool)
    frame[cells_of(rows, pad, glyphs)] = True
    return frame


def around_edges(rows: Rows, pad: int) -> np.ndarray:
    """Returns, for a map that wraps, the cell of the map that each cell of the frame is: `[2 * cells]` int32.

    The second half is cell 1, where nobody ever is: there lie the cells that `shape_offsets` leaves out. Not cell 0, the place of
    those who have none: they would be in every shape that has more cells than the map. So the margin is at least one cell.
    """
    height, width = frame_size(rows, pad)
    row = (np.arange(height) - pad) % len(rows) + pad
    col = (np.arange(width) - pad) % len(rows[0]) + pad
    cells = (row[:, None] * width + col[None]).reshape(-1)
    return np.concatenate([cells, np.ones_like(cells)]).astype(np.int32)


def site_numbers(rows: Rows, pad: int, cells: np.ndarray) -> np.ndarray:
    """Returns each cell's number among `cells`, past their end for all others: `[cells of the frame]` int32."""
    height, width = frame_size(rows, pad)
    table = np.full(height * width, len(cells), np.int32)
    table[cells] = np.arange(len(cells))
    return table


def next_cells(rows: Rows, pad: int, glyphs: str, wraps: bool = False) -> np.ndarray:
    """Returns where a step leads, `[cells * 4]` int32 by cell and direction.

    The cell itself where the step leaves the map (if it does not wrap) or enters a cell with one of the glyphs.
    """
    _, width = frame_size(rows, pad)
    open_ = inside(rows, pad) & ~blocking(rows, pad, glyphs)
    cells = np.arange(open_.size)
    table = np.stack([cells] * 4, 1)
    here = np.flatnonzero(inside(rows, pad))
    for direction, (dr, dc) in enumerate(DIRECTIONS):
        target = here + dr * width + dc
        target = around_edges(rows, pad)[target] if wraps else target
        table[here, direction] = np.where(open_[target], target, here)
    return table.reshape(-1).astype(np.int32)


def shape_offsets(
    rows: Rows, pad: int, cells: Sequence[tuple[int, int]], wraps: bool = False
) -> np.ndarray:
    """Returns what to add to an agent's cell for each heading and (ahead, right) of a shape: `[4, K]` int32.

    wraps: of cells of the shape that are one cell of such a map all but the first are left out, and so is the agent's own cell but for
    (0, 0). What is added there leads to nowhere in `around_edges`.
    """
    height, width = frame_size(rows, pad)
    table = np.zeros((4, len(cells)), np.int32)
    for heading in range(4):
        met = {(0, 0)}
        for number, (down, right) in enumerate(turned(cells, heading)):
            place = (down % len(rows), right % len(rows[0]))
            again = wraps and place in met and (down, right) != (0, 0)
            table[heading, number] = height * width if again else down * width + right
            met.add(place)
    return table


def turned(cells: Sequence[tuple[int, int]], heading: int) -> list[tuple[int, int]]:
    """Returns how many rows down and columns to the right each (ahead, right) is for one who faces a heading."""
    ahead, right = DIRECTIONS[heading], DIRECTIONS[(heading + 1) % 4]
    return [(a * ahead[0] + c * right[0], a * ahead[1] + c * right[1]) for a, c in cells]


def lane_reach(
    rows: Rows,
    pad: int,
    offsets: np.ndarray,
    lanes: Sequence[int],
    glyphs: str,
    wraps: bool = False,
) -> np.ndarray:
    """Returns which shape cells are on the map and not behind a cell with one of the glyphs, which ends its lane.

    Args:
      offsets: `[4, K]` of `shape_offsets`; lanes: number of cells of each lane, in order.
    Returns:
      `[cells * 4]` bits, bit k for shape cell k: uint8 for up to 8 cells, else uint32.
    """
    blocked, on_map = blocking(rows, pad, glyphs), inside(rows, pad)
    here = np.flatnonzero(on_map)
    bits = np.zeros((on_map.size, 4), np.uint64)
    if wraps:
        blocked, on_map = (cells[around_edges(rows, pad)] for cells in (blocked, on_map))
    for heading in range(4):
        number = 0
        for length in lanes:
            live = np.ones(here.size, bool)
            for _ in range(length):
                target = here + offsets[heading, number]
                bits[here, heading] |= (live & on_map[target]).astype(np.uint64) << np.uint64(
                    number
                )
                live &= ~blocked[target]
                number += 1
    return bits.reshape(-1).astype(np.uint8 if offsets.shape[1] <= 8 else np.uint32)


def neighbours(cells: np.ndarray, numbers: np.ndarray, offsets: np.ndarray) -> np.ndarray:
    """Returns, for each cell, the numbers of the cells of an undirected shape around it: `[S, K]` int32.

    Args:
      numbers: of `site_numbers`; where the map wraps, its entries for the cells of `around_edges`.
    """
    result: np.ndarray = numbers[cells[:, None] + offsets[0][None]]
    return result


def near_masks(around: np.ndarray, size: int) -> np.ndarray:
    """Returns `[ceil(size / 32), S]` uint32: bit k of word w is set if cell 32 w + k is a neighbour.

    Args:
      around: `[S, K]` int, numbers of the neighbours, `size` for none.
      size: number of cells that can be neighbours.
    """
    masks = np.zeros((-(-size // 32), len(around)), np.uint32)
    for site, row in enumerate(around):
        for other in row[row < size]:
            masks[other // 32, site] |= np.uint32(1) << np.uint32(other % 32)
    return masks


def view_offsets(
    rows: Rows, pad: int, ahead: int, behind: int, left: int, right: int
) -> np.ndarray:
    """Returns what to add to an agent's cell for each heading and cell of its window, row by row: `[4, V]` int32."""
    return shape_offsets(rows, pad, _view(ahead, behind, left, right))


def view_steps(ahead: int, behind: int, left: int, right: int) -> np.ndarray:
    """Returns how many steps each cell of a window is from the agent: `[V]` int32."""
    return np.array([abs(a) + abs(c) for a, c in _view(ahead, behind, left, right)], np.int32)


def view_steps_around(rows: Rows, ahead: int, behind: int, left: int, right: int) -> np.ndarray:
    """Returns how many steps each cell of a window is from the agent on a map that wraps, for each heading: `[4, V]` int32."""
    height, width = len(rows), len(rows[0])
    views = [turned(_view(ahead, behind, left, right), heading) for heading in range(4)]
    return np.array(
        [
            [min(r % height, -r % height) + min(c % width, -c % width) for r, c in cells]
            for cells in views
        ],
        np.int32,
    )


def view_cells(ahead: int, behind: int, left: int, right: int, *own: int) -> np.ndarray:
    """Returns which cells of a window are in one with other sides (`own`: ahead, behind, left, right): `[V]` bool."""
    view = _view(ahead, behind, left, right)
    return np.array([-own[1] <= a <= own[0] and -own[2] <= c <= own[3] for a, c in view])


def _view(ahead: int, behind: int, left: int, right: int) -> list[tuple[int, int]]:
    """Returns (ahead, right) of each cell of a window, row by row."""
    return [(a, c) for a in range(ahead, -behind - 1, -1) for c in range(-left, right + 1)]


def own_cells(rows: Rows, ahead: int, behind: int, left: int, right: int) -> np.ndarray:
    """Returns which cells of a window show the observer's own on a map that wraps, for each heading: `[4, V]` bool."""
    own: np.ndarray = view_steps_around(rows, ahead, behind, left, right) == 0
    return own


def own_cell(rows: int, columns: int, row: int, column: int) -> np.ndarray:
    """Returns which cell of its window is the observer's own: `[rows * columns]` bool."""
    result: np.ndarray = np.arange(rows * columns) == row * columns + column
    return result

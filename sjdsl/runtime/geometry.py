"""Static geometry: tables of a padded map, and where a beam ends at a wall (`lane_reach`).

The padding keeps windows and shapes in the frame. A cell is its index in the padded frame,
`(row + pad) * columns + column + pad`; cell 0, in the padding, is nowhere. All tables are NumPy
arrays, computed once, when a module is loaded.
"""

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from sjdsl.runtime.actions import DIRECTIONS

Rows = Sequence[str]


def frame_size(rows: Rows, pad: int) -> tuple[int, int]:
    """Returns the rows and columns of the padded frame."""
    return len(rows) + 2 * pad, len(rows[0]) + 2 * pad


def _framed(rows: Rows, pad: int, value: Callable[[str], object], dtype: type) -> np.ndarray:
    """Returns the frame with the value of each glyph, 0 outside the map: `[cells]`."""
    frame: np.ndarray = np.zeros(frame_size(rows, pad), dtype)
    for number, row in enumerate(rows, pad):
        frame[number, pad : pad + len(row)] = [value(glyph) for glyph in row]
    return frame.reshape(-1)


def cells_of(rows: Rows, pad: int, glyphs: str) -> np.ndarray:
    """Returns the cells with one of the glyphs in reading order: `[S]` int32."""
    return np.flatnonzero(blocking(rows, pad, glyphs)).astype(np.int32)


def numbers_among(rows: Rows, group: str, glyphs: str) -> np.ndarray:
    """Returns the index of each cell of a group among those with one of `glyphs`: `[S + 1]` int32.

    Cells are in reading order. The index is past the end for the other cells, and for one more
    entry after the last cell.
    """
    glyphs_of_group = [glyph for glyph in "".join(rows) if glyph in group]
    is_among = np.array([*(glyph in glyphs for glyph in glyphs_of_group), False])
    index = np.cumsum(is_among) - 1
    return np.where(is_among, index, is_among.sum()).astype(np.int32)


def reading_order(rows: Rows, kinds: Sequence[str]) -> np.ndarray:
    """Returns the index of each cell of a group in an order by kind: `[S]` int32.

    The cells of each kind, and the entries of the result, are in reading order.

    Args:
      kinds: the glyphs of each kind of the group.
    """
    kind_of_glyph = {glyph: number for number, glyphs in enumerate(kinds) for glyph in glyphs}
    kind_of_cell = [kind_of_glyph[g] for g in "".join(rows) if g in kind_of_glyph]
    return np.argsort(np.argsort(kind_of_cell, kind="stable")).astype(np.int32)


def values_of(rows: Rows, values: Mapping[str, float], dtype: str) -> np.ndarray:
    """Returns the value of each cell whose glyph has one, in reading order: `[S]`."""
    return np.array([values[g] for g in "".join(rows) if g in values], dtype)


def painted(rows: Rows, pad: int, values: Mapping[str, int]) -> np.ndarray:
    """Returns the frame with each glyph's value, 0 outside the map: `[cells]` uint8."""
    return _framed(rows, pad, values.__getitem__, np.uint8)


def inside(rows: Rows, pad: int) -> np.ndarray:
    """Returns which cells of the frame are on the map: `[cells]` bool."""
    return _framed(rows, pad, lambda _: True, bool)


def blocking(rows: Rows, pad: int, glyphs: str) -> np.ndarray:
    """Returns which cells of the frame have one of the glyphs: `[cells]` bool."""
    return _framed(rows, pad, glyphs.__contains__, bool)


def around_edges(rows: Rows, pad: int) -> np.ndarray:
    """Returns, for a map that wraps, the cell of the map at each cell of the frame: `[2 * cells]`.

    The result is int32. Its second half is for the cells that `shape_offsets` leaves out: cell 1,
    in the padding of at least one cell, where nobody ever is. Cell 0 is the position of those that
    are away, who would be in every shape with more cells than the map.
    """
    height, width = frame_size(rows, pad)
    row = (np.arange(height) - pad) % len(rows) + pad
    col = (np.arange(width) - pad) % len(rows[0]) + pad
    cells = (row[:, None] * width + col[None]).reshape(-1)
    return np.concatenate([cells, np.ones_like(cells)]).astype(np.int32)


def site_numbers(rows: Rows, pad: int, cells: np.ndarray) -> np.ndarray:
    """Returns the index among `cells` of each cell of the frame, past the end for others: int32."""
    height, width = frame_size(rows, pad)
    table = np.full(height * width, len(cells), np.int32)
    table[cells] = np.arange(len(cells))
    return table


def next_cells(rows: Rows, pad: int, glyphs: str, wraps: bool = False) -> np.ndarray:
    """Returns where a step leads, `[cells * 4]` int32 by cell and direction.

    It is the cell itself if the step leaves a map that doesn't wrap, or enters a cell with one of
    the glyphs.
    """
    _, width = frame_size(rows, pad)
    on_map = inside(rows, pad)
    enterable = on_map & ~blocking(rows, pad, glyphs)
    table = np.stack([np.arange(on_map.size)] * 4, 1)
    cells = np.flatnonzero(on_map)
    for direction, (down, right) in enumerate(DIRECTIONS):
        target = cells + down * width + right
        if wraps:
            target = around_edges(rows, pad)[target]
        table[cells, direction] = np.where(enterable[target], target, cells)
    return table.reshape(-1).astype(np.int32)


def shape_offsets(
    rows: Rows, pad: int, cells: Sequence[tuple[int, int]], wraps: bool = False
) -> np.ndarray:
    """Returns what to add to an agent's cell to reach each cell of a shape: `[4, K]` int32.

    Args:
      cells: (ahead, right) of the shape.
      wraps: whether the map's edges are joined. Of cells of the shape that are the same cell of the
        map all but the first are left out, and so is the agent's cell, except as (0, 0). Their
        offset leads to nowhere in `around_edges`.
    """
    height, width = frame_size(rows, pad)
    table = np.zeros((4, len(cells)), np.int32)
    for heading in range(4):
        used = {(0, 0)}
        for number, (down, right) in enumerate(turned(cells, heading)):
            cell = (down % len(rows), right % len(rows[0]))
            is_left_out = wraps and cell in used and (down, right) != (0, 0)
            table[heading, number] = height * width if is_left_out else down * width + right
            used.add(cell)
    return table


def turned(cells: Sequence[tuple[int, int]], heading: int) -> list[tuple[int, int]]:
    """Returns the (rows down, columns to the right) of each (ahead, right) with a heading."""
    ahead = DIRECTIONS[heading]
    right = DIRECTIONS[(heading + 1) % 4]
    rows_and_cols = []
    for num_ahead, num_right in cells:
        down = num_ahead * ahead[0] + num_right * right[0]
        across = num_ahead * ahead[1] + num_right * right[1]
        rows_and_cols.append((down, across))
    return rows_and_cols


def lane_reach(
    rows: Rows,
    pad: int,
    offsets: np.ndarray,
    lanes: Sequence[int],
    glyphs: str,
    wraps: bool = False,
) -> np.ndarray:
    """Returns which cells of a shape are on the map and not behind one that ends its lane.

    Args:
      offsets: `[4, K]` of `shape_offsets`; lanes: number of cells of each lane, in order.
      glyphs: of the cells that end lanes.

    Returns:
      `[cells * 4]` bits, bit k for shape cell k: uint8 for up to 8 cells, else uint32.
    """
    ends_lane = blocking(rows, pad, glyphs)
    on_map = inside(rows, pad)
    cells = np.flatnonzero(on_map)
    bits = np.zeros((on_map.size, 4), np.uint64)
    if wraps:
        ends_lane = ends_lane[around_edges(rows, pad)]
        on_map = on_map[around_edges(rows, pad)]
    for heading in range(4):
        number = 0
        for length in lanes:
            is_open = np.ones(cells.size, bool)
            for _ in range(length):
                target = cells + offsets[heading, number]
                is_reached = (is_open & on_map[target]).astype(np.uint64)
                bits[cells, heading] |= is_reached << np.uint64(number)
                is_open &= ~ends_lane[target]
                number += 1
    dtype = np.uint8 if offsets.shape[1] <= 8 else np.uint32
    return bits.reshape(-1).astype(dtype)


def neighbours(cells: np.ndarray, numbers: np.ndarray, offsets: np.ndarray) -> np.ndarray:
    """Returns the indices of the cells of an undirected shape around each cell: `[S, K]` int32.

    Args:
      numbers: of `site_numbers`; if the map wraps, its entries for the cells of `around_edges`.
    """
    result: np.ndarray = numbers[cells[:, None] + offsets[0][None]]
    return result


def near_masks(around: np.ndarray, size: int) -> np.ndarray:
    """Returns the neighbours of each cell as bits, `[ceil(size / 32), S]` uint32.

    Bit k of entry w is set if cell 32 w + k is a neighbour.

    Args:
      around: `[S, K]` int, indices of the neighbours, `size` for none.
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
    """Returns what to add to an agent's cell to reach each cell of its window: `[4, V]` int32."""
    return shape_offsets(rows, pad, _view(ahead, behind, left, right))


def view_steps(ahead: int, behind: int, left: int, right: int) -> np.ndarray:
    """Returns how many steps each cell of a window is from the agent: `[V]` int32."""
    view = np.array(_view(ahead, behind, left, right), np.int32)
    steps: np.ndarray = np.abs(view).sum(axis=1, dtype=np.int32)
    return steps


def view_steps_around(rows: Rows, ahead: int, behind: int, left: int, right: int) -> np.ndarray:
    """Returns the steps to each cell of a window if the map wraps, by heading: `[4, V]` int32."""
    height = len(rows)
    width = len(rows[0])
    view = _view(ahead, behind, left, right)
    steps = np.zeros((4, len(view)), np.int32)
    for heading in range(4):
        for number, (down, across) in enumerate(turned(view, heading)):
            num_rows = min(down % height, -down % height)
            num_cols = min(across % width, -across % width)
            steps[heading, number] = num_rows + num_cols
    return steps


def view_cells(ahead: int, behind: int, left: int, right: int, *sides: int) -> np.ndarray:
    """Returns which cells of a window are also in a smaller one: `[V]` bool.

    Args:
      sides: of the smaller window: ahead, behind, left, right.
    """
    smaller = set(_view(*sides))
    return np.array([cell in smaller for cell in _view(ahead, behind, left, right)])


def _view(ahead: int, behind: int, left: int, right: int) -> list[tuple[int, int]]:
    """Returns (ahead, right) of each cell of a window, row by row."""
    columns = range(-left, right + 1)
    return [(row, column) for row in range(ahead, -behind - 1, -1) for column in columns]


def own_cells(rows: Rows, ahead: int, behind: int, left: int, right: int) -> np.ndarray:
    """Returns which cells of a window are the observer's on a map that wraps: `[4, V]` bool."""
    result: np.ndarray = view_steps_around(rows, ahead, behind, left, right) == 0
    return result


def own_cell(rows: int, columns: int, row: int, column: int) -> np.ndarray:
    """Returns which cell of its window is the observer's: `[rows * columns]` bool."""
    result: np.ndarray = np.arange(rows * columns) == row * columns + column
    return result

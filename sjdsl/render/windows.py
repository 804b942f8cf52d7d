"""Draws what each agent observes: its egocentric window of the board, rotated so that its heading points up."""

import numpy as np

from sjdsl.compiler import ir
from sjdsl.render.snapshot import Snapshot
from sjdsl.runtime.actions import DIRECTIONS

STEPS = np.array(DIRECTIONS)
OUTSIDE = NONE = 0  # in an observation: the look of what is off the map, and that no agent is seen on a cell


def draw_windows(board: np.ndarray, snapshot: Snapshot, window: ir.Window, tile: int) -> np.ndarray:
    """Returns the windows of all agents, `[N, rows * tile, cols * tile, 3]` uint8; off the map, and for who is away, all is black.

    Args:
      board: of `draw_board`, `[H * tile, W * tile, 3]` uint8.
      tile: pixels of a cell's side.
    """
    height, width = board.shape[0] // tile, board.shape[1] // tile
    tiles = np.zeros((height + 1, width + 1, tile, tile, 3), np.uint8)  # the last row and column are off the map
    tiles[:height, :width] = board.reshape(height, tile, width, tile, 3).swapaxes(1, 2)
    ahead = np.arange(window.ahead, -window.behind - 1, -1)[:, None, None]
    right = np.arange(-window.left, window.right + 1)[None, :, None]
    pictures = []
    for row, col, heading in zip(snapshot.row, snapshot.col, snapshot.heading, strict=True):
        cells = np.array((row, col)) + ahead * STEPS[heading] + right * STEPS[(heading + 1) % 4]
        on_map = (row >= 0) & ((cells >= 0) & (cells < (height, width))).all(axis=-1, keepdims=True)
        rows, cols = np.moveaxis(np.where(on_map, cells, -1), -1, 0)
        seen = np.rot90(tiles[rows, cols], int(heading), axes=(2, 3))
        pictures.append(seen.swapaxes(1, 2).reshape(ahead.size * tile, right.size * tile, 3))
    return np.stack(pictures)


def where_seen(seen: np.ndarray, windows: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Returns the cells of `windows` that are seen, elsewhere those of `others`.

    Args:
      seen: `[N, rows, cols]` bool.
      windows, others: `[N, rows * tile, cols * tile, 3]` uint8.
    """
    number, rows, cols = seen.shape
    cells = (number, rows, windows.shape[1] // rows, cols, windows.shape[2] // cols, 3)
    return np.where(seen[:, :, None, :, None, None], windows.reshape(cells), others.reshape(cells)).reshape(windows.shape)

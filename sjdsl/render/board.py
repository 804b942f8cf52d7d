"""Draws boards as pixels.

Cells and figures are rasterised SVG. The numbers of agents are drawn here: resvg has no font.
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from io import BytesIO

import numpy as np

from sjdsl.compiler import ir
from sjdsl.extras import needs
from sjdsl.render.appearance import Beam, Drawing, Figure, appearance_of
from sjdsl.render.look import Look
from sjdsl.render.moment import Snapshot
from sjdsl.render.vector import number_ink, number_place, vector_figure, vector_tile
from sjdsl.runtime.actions import DIRECTIONS

with needs("pictures"):
    from PIL import Image, ImageDraw, ImageFont
    from resvg_py import svg_to_bytes

SMALLEST_WITH_NUMBER = 15  # pixels of a tile
FINE = 4  # numbers are drawn this many times larger, then shrunk
KEPT = 4096  # pictures of cells, and as many of figures
STEPS = np.array(DIRECTIONS)


def draw_board(
    look: Look, snapshot: Snapshot, actions: Sequence[int] = (), before: Snapshot | None = None
) -> np.ndarray:
    """Returns the board at one moment, `[H * tile, W * tile, 3]` uint8.

    The arguments are those of `appearance_of`.
    """
    appearance = appearance_of(look, snapshot, actions, before)
    size = look.tile
    tiles = np.stack([draw_tile(drawing, size) for drawing in appearance.drawings])
    board: np.ndarray = tiles[appearance.cells].swapaxes(1, 2)  # [H, tile, W, tile, 3]
    for figure, row, col in appearance.figures:
        put_figure(board[row, :, col], figure)
    return board.reshape(look.height * size, look.width * size, 3)


@lru_cache(KEPT)
def draw_tile(drawing: Drawing, size: int) -> np.ndarray:
    """Returns the tile of a cell, `[size, size, 3]` uint8."""
    return np.asarray(_rasterised(vector_tile(drawing, size)).convert("RGB"))


def put_figure(tile: np.ndarray, figure: Figure | Beam) -> None:
    """Draws an agent, a mover or a beam on its cell, `[size, size, 3]` uint8, in place."""
    picture = draw_figure(figure, tile.shape[0])
    opacity = picture[..., 3:].astype(np.float32) / 255
    tile[...] = np.round(tile * (1 - opacity) + picture[..., :3] * opacity).astype(np.uint8)


@lru_cache(KEPT)
def draw_figure(figure: Figure | Beam, size: int) -> np.ndarray:
    """Returns an agent or a mover with what it carries, or a beam, as RGBA, `[size, size, 4]`."""
    if isinstance(figure, Beam):
        return np.asarray(_rasterised(vector_figure(figure, size=size)))
    picture = _rasterised(vector_figure(replace(figure, number=None), size=size))
    if figure.number is not None and size >= SMALLEST_WITH_NUMBER:
        x, y, height = number_place(figure)
        side = size * FINE
        image = Image.new("RGBA", (side, side))
        ImageDraw.Draw(image).text(
            (side * x, side * y),
            str(figure.number),
            (*number_ink(figure), 255),
            ImageFont.load_default(side * height),
            anchor="mm",
            stroke_width=FINE / 5,
        )
        picture.alpha_composite(image.resize((size, size), Image.Resampling.BOX))
    return np.asarray(picture)


def _rasterised(svg: str) -> Image.Image:
    """Returns SVG as an RGBA picture of the size that it states."""
    png = bytes(svg_to_bytes(svg_string=svg, skip_system_fonts=True))
    return Image.open(BytesIO(png)).convert("RGBA")


def draw_windows(board: np.ndarray, snapshot: Snapshot, window: ir.Window, tile: int) -> np.ndarray:
    """Returns the windows of all agents, `[N, rows * tile, cols * tile, 3]` uint8.

    Cells off the map, and the windows of agents that are away, are black.

    Args:
      board: from `draw_board`, `[H * tile, W * tile, 3]` uint8.
      tile: pixels of a cell's side.
    """
    height = board.shape[0] // tile
    width = board.shape[1] // tile
    # The last row and column are off the map.
    tiles = np.zeros((height + 1, width + 1, tile, tile, 3), np.uint8)  # by row and column of cells
    tiles[:height, :width] = board.reshape(height, tile, width, tile, 3).swapaxes(1, 2)
    ahead = np.arange(window.ahead, -window.behind - 1, -1)[:, None, None]  # [rows, 1, 1] cells
    right = np.arange(-window.left, window.right + 1)[None, :, None]  # [1, cols, 1] cells
    pictures = []
    for row, col, heading in zip(snapshot.row, snapshot.col, snapshot.heading, strict=True):
        # [rows, cols, 2]: the row and the column on the map of each cell of the window
        to_cells = ahead * STEPS[heading] + right * STEPS[(heading + 1) % 4]
        cells = np.array((row, col)) + to_cells
        is_inside = ((cells >= 0) & (cells < (height, width))).all(axis=-1, keepdims=True)
        is_present = row >= 0
        cells = np.where(is_present & is_inside, cells, -1)
        # [rows, cols, tile, tile, 3], each tile turned as the window is; then pixels row by row
        turned = np.rot90(tiles[cells[..., 0], cells[..., 1]], int(heading), axes=(2, 3))
        picture = turned.swapaxes(1, 2)
        pictures.append(picture.reshape(ahead.size * tile, right.size * tile, 3))
    return np.stack(pictures)


def where_seen(seen: np.ndarray, windows: np.ndarray) -> np.ndarray:
    """Returns `windows` with black where agents see nothing.

    Args:
      seen: `[N, rows, cols]` bool, whether an agent sees a cell.
      windows: `[N, rows * tile, cols * tile, 3]` uint8.
    """
    num_agents, rows, cols = seen.shape
    height = windows.shape[1] // rows
    width = windows.shape[2] // cols
    tiles = windows.reshape(num_agents, rows, height, cols, width, 3)
    return np.where(seen[:, :, None, :, None, None], tiles, 0).reshape(windows.shape)

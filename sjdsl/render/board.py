"""Draws boards as pixels: the SVG of cells and figures, rasterised, and numbers of agents, for which resvg has no font."""

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
    """Returns the board of one moment, `[H * tile, W * tile, 3]` uint8; the arguments are those of `appearance_of`."""
    seen, size = appearance_of(look, snapshot, actions, before), look.tile
    tiles = np.stack([draw_tile(drawing, size) for drawing in seen.drawings])
    board: np.ndarray = tiles[seen.cells].swapaxes(1, 2)  # [H, tile, W, tile, 3]
    for figure, row, col in seen.figures:
        put_figure(board[row, :, col], figure)
    return board.reshape(look.height * size, look.width * size, 3)


@lru_cache(KEPT)
def draw_tile(drawing: Drawing, size: int) -> np.ndarray:
    """Returns the tile of a cell, `[size, size, 3]` uint8."""
    return np.asarray(_rasterised(vector_tile(drawing, size)).convert("RGB"))


def put_figure(tile: np.ndarray, figure: Figure | Beam) -> None:
    """Draws an agent, a mover or a beam on its cell, `[size, size, 3]` uint8, in place."""
    drawn = draw_figure(figure, tile.shape[0])
    opacity = drawn[..., 3:].astype(np.float32) / 255
    tile[...] = np.round(tile * (1 - opacity) + drawn[..., :3] * opacity).astype(np.uint8)


@lru_cache(KEPT)
def draw_figure(figure: Figure | Beam, size: int) -> np.ndarray:
    """Returns the picture of an agent or a mover with what it carries, or of a beam, `[size, size, 4]` uint8 with opacity."""
    if isinstance(figure, Beam):
        return np.asarray(_rasterised(vector_figure(figure, size=size)))
    picture = _rasterised(vector_figure(replace(figure, number=None), size=size))
    if figure.number is not None and size >= SMALLEST_WITH_NUMBER:
        x, y, height = number_place(figure)
        side = size * FINE
        image = Image.new("RGBA", (side, side))
        pen, font = ImageDraw.Draw(image), ImageFont.load_default(side * height)
        pen.text(
            (side * x, side * y),
            str(figure.number),
            (*number_ink(figure), 255),
            font,
            anchor="mm",
            stroke_width=FINE / 5,
        )
        picture.alpha_composite(image.resize((size, size), Image.Resampling.BOX))
    return np.asarray(picture)


def _rasterised(svg: str) -> Image.Image:
    """Returns SVG as pixels with opacity, as many as it says."""
    return Image.open(BytesIO(bytes(svg_to_bytes(svg_string=svg, skip_system_fonts=True)))).convert(
        "RGBA"
    )


def draw_windows(board: np.ndarray, snapshot: Snapshot, window: ir.Window, tile: int) -> np.ndarray:
    """Returns the windows of all agents, `[N, rows * tile, cols * tile, 3]` uint8; off the map, and for who is away, all is black.

    Args:
      board: of `draw_board`, `[H * tile, W * tile, 3]` uint8.
      tile: pixels of a cell's side.
    """
    height, width = board.shape[0] // tile, board.shape[1] // tile
    tiles = np.zeros(
        (height + 1, width + 1, tile, tile, 3), np.uint8
    )  # the last row and column are off the map
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


def where_seen(seen: np.ndarray, windows: np.ndarray) -> np.ndarray:
    """Returns the cells of `windows` that are seen, black elsewhere.

    Args:
      seen: `[N, rows, cols]` bool.
      windows: `[N, rows * tile, cols * tile, 3]` uint8.
    """
    number, rows, cols = seen.shape
    cells = (number, rows, windows.shape[1] // rows, cols, windows.shape[2] // cols, 3)
    return np.where(seen[:, :, None, :, None, None], windows.reshape(cells), 0).reshape(
        windows.shape
    )

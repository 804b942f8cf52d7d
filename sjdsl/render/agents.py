"""Agents: a triangle that points where the agent looks, with its number."""

from functools import cache

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from sjdsl.render.colours import INK, PAPER, Colour
from sjdsl.render.tiles import FINE, mixed

SMALLEST_WITH_NUMBER = 19  # pixels of a tile


@cache
def draw_agent(number: int, colour: Colour, heading: int, size: int, held: bool) -> np.ndarray:
    """Returns the agent's picture, `[size, size, 4]` uint8 with opacity; paler if `held`."""
    side = size * FINE
    fill = mixed(colour, PAPER, 0.6) if held else colour
    image = Image.new("RGBA", (side, side), (*INK, 0))
    pen = ImageDraw.Draw(image)
    corners = [(0.5, 0.04), (0.95, 0.94), (0.05, 0.94)]  # looking north
    for _ in range(heading):
        corners = [(1 - y, x) for x, y in corners]
    edge = max(FINE, round(side * 0.05))
    pen.polygon([(x * side, y * side) for x, y in corners], (*fill, 255), (*INK, 255), edge)
    if size >= SMALLEST_WITH_NUMBER:
        _write_number(pen, number, corners, side, fill)
    return np.asarray(image.resize((size, size), Image.Resampling.BOX))


def _write_number(pen: ImageDraw.ImageDraw, number: int, corners: list[tuple[float, float]], side: int, fill: Colour) -> None:
    centre = tuple(sum(corner[axis] for corner in corners) / 3 * side for axis in (0, 1))
    font = ImageFont.load_default(side * (0.42 if number < 10 else 0.32))
    ink = PAPER if sum(w * c for w, c in zip((0.3, 0.59, 0.11), fill, strict=True)) < 150 else INK
    pen.text(centre, str(number), fill=(*ink, 255), font=font, anchor="mm", stroke_width=FINE // 4)


def paste(board: np.ndarray, picture: np.ndarray, row: int, col: int) -> None:
    """Lays a picture with opacity onto the cell (row, col) of a board `[H, size, W, size, 3]`, in place."""
    opacity = picture[..., 3:].astype(np.float32) / 255
    under = board[row, :, col].astype(np.float32)
    board[row, :, col] = np.round(under * (1 - opacity) + picture[..., :3] * opacity).astype(np.uint8)

"""Draws cells, agents and movers as pixels: their SVG, rasterised, and the number of an agent, for which resvg has no font."""

from dataclasses import replace
from functools import cache
from io import BytesIO

import numpy as np

from sjdsl.extras import needs
from sjdsl.render.colours import Colour
from sjdsl.render.drawings import Drawing, Figure
from sjdsl.render.vector import number_ink, number_place, vector_figure, vector_tile

with needs("pictures"):
    from PIL import Image, ImageDraw, ImageFont
    from resvg_py import svg_to_bytes

SMALLEST_WITH_NUMBER = 15  # pixels of a tile
FINE = 4  # numbers are drawn this many times larger, then shrunk


def draw_tile(drawing: Drawing, size: int) -> np.ndarray:
    """Returns the tile of a cell, `[size, size, 3]` uint8."""
    return np.asarray(rasterised(vector_tile(drawing, size)).convert("RGB"))


def put_figure(tile: np.ndarray, figure: Figure) -> None:
    """Draws an agent or a mover on its cell, `[size, size, 3]` uint8, in place."""
    drawn = draw_figure(figure, tile.shape[0])
    opacity = drawn[..., 3:].astype(np.float32) / 255
    tile[...] = np.round(tile * (1 - opacity) + drawn[..., :3] * opacity).astype(np.uint8)


@cache
def draw_figure(figure: Figure, size: int) -> np.ndarray:
    """Returns the picture of an agent or a mover with what it carries, `[size, size, 4]` uint8 with opacity."""
    picture = rasterised(vector_figure(replace(figure, number=None), size=size))
    if figure.number is not None and size >= SMALLEST_WITH_NUMBER:
        x, y, height = number_place(figure)
        side = size * FINE
        image = Image.new("RGBA", (side, side))
        pen, font = ImageDraw.Draw(image), ImageFont.load_default(side * height)
        pen.text((side * x, side * y), str(figure.number), (*number_ink(figure), 255), font, anchor="mm", stroke_width=FINE / 5)
        picture.alpha_composite(image.resize((size, size), Image.Resampling.BOX))
    return np.asarray(picture)


def rasterised(svg: str) -> Image.Image:
    """Returns SVG as pixels with opacity, as many as it says."""
    return Image.open(BytesIO(bytes(svg_to_bytes(svg_string=svg, skip_system_fonts=True)))).convert("RGBA")


def tinted(pixels: np.ndarray, colour: Colour, share: float) -> np.ndarray:
    """Returns pixels with a share of a colour."""
    under = pixels.astype(np.float32)
    return np.round(under + (np.array(colour) - under) * share).astype(np.uint8)

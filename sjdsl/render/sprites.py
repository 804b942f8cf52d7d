"""Sprites: small SVG drawings, tinted, and rasterised once for each size, colour and heading."""

from functools import cache
from importlib.resources import files
from io import BytesIO

import numpy as np

from sjdsl.extras import needs
from sjdsl.render.colours import Colour

FILLING = frozenset({"wall", "water", "floor"})  # these are as large as their cell, the others stand in it
SHAPES = ("disc", "diamond", "square", "triangle", "ring", "cross", "hexagon", "wedge")  # of words that have no sprite of their own


@cache
def draw_sprite(name: str, colour: Colour, size: int, turns: int = 0) -> np.ndarray:
    """Returns a sprite, `[size, size, 4]` uint8 with opacity.

    Args:
      name: of a file in `sprites/`; what is drawn there in `currentColor` takes `colour`.
      turns: quarter turns to the right.
    """
    with needs("pictures"):
        from PIL import Image  # a game that is never drawn needs no rasteriser, nor one that a browser draws
        from resvg_py import svg_to_bytes

    svg = sprite_source(name).replace("currentColor", "#{:02x}{:02x}{:02x}".format(*colour))
    png = svg_to_bytes(svg_string=svg, width=size, height=size, skip_system_fonts=True)
    with Image.open(BytesIO(bytes(png))) as image:
        return np.rot90(np.asarray(image.convert("RGBA")), -turns)


@cache
def sprite_source(name: str) -> str:
    """Returns the SVG text of a sprite; `currentColor` stands where its colour goes."""
    return files("sjdsl.render").joinpath(f"sprites/{name}.svg").read_text(encoding="utf-8")


def lay(under: np.ndarray, over: np.ndarray, top: int = 0, left: int = 0) -> None:
    """Lays a picture with opacity onto another one, `[rows, columns, 3]` uint8, in place; what sticks out is cut off."""
    height, width = min(over.shape[0], under.shape[0] - top), min(over.shape[1], under.shape[1] - left)
    over = over[:height, :width]
    part = under[top : top + height, left : left + width]
    opacity = over[..., 3:].astype(np.float32) / 255
    part[...] = np.round(part * (1 - opacity) + over[..., :3] * opacity).astype(np.uint8)

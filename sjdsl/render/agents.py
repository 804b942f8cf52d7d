"""Draws agents and movers as pixels: a body that faces the heading, the number of an agent, and what is carried."""

from functools import cache

import numpy as np

from sjdsl.extras import needs
from sjdsl.render.colours import INK, PAPER, Colour, mixed
from sjdsl.render.drawings import PALE, Figure
from sjdsl.render.sprites import draw_sprite
from sjdsl.render.tiles import badges_at, put_badges
from sjdsl.runtime.actions import DIRECTIONS

with needs("pictures"):
    from PIL import Image, ImageDraw, ImageFont

SMALLEST_WITH_NUMBER = 15  # pixels of a tile
FINE = 4  # numbers are drawn this many times larger, then shrunk


def put_figure(tile: np.ndarray, figure: Figure) -> None:
    """Draws an agent or a mover on its cell, `[size, size, 3]` uint8, in place."""
    body = draw_body(figure.number, figure.colour, figure.sprite, figure.heading, tile.shape[0], figure.held)
    opacity = body[..., 3:].astype(np.float32) / 255
    tile[...] = np.round(tile * (1 - opacity) + body[..., :3] * opacity).astype(np.uint8)
    put_badges(tile, figure.badges)


@cache
def draw_figure(figure: Figure, size: int) -> np.ndarray:
    """Returns the picture of an agent or a mover with what it carries, `[size, size, 4]` uint8 with opacity."""
    body = draw_body(figure.number, figure.colour, figure.sprite, figure.heading, size, figure.held)
    picture = Image.fromarray(body).copy()
    for (top, left), badge in badges_at(figure.badges, size):
        picture.alpha_composite(Image.fromarray(badge), (left, top))
    return np.asarray(picture)


@cache
def draw_body(number: int | None, colour: Colour, sprite: str, heading: int, size: int, held: bool) -> np.ndarray:
    """Returns the picture of an agent, or without a number of a mover, `[size, size, 4]` uint8 with opacity; paler if `held`."""
    fill = mixed(colour, PAPER, PALE) if held else colour
    body = draw_sprite(sprite, fill, size, heading).copy()
    if held:  # its edge and eyes, too
        body[..., :3] = np.round(body[..., :3] * (1 - PALE / 2) + 255 * PALE / 2).astype(np.uint8)
    if number is None or size < SMALLEST_WITH_NUMBER:
        return body
    under = Image.fromarray(body)
    under.alpha_composite(_number(number, fill, heading, size, held))
    return np.asarray(under)


def _number(number: int, fill: Colour, heading: int, size: int, held: bool) -> Image.Image:
    """Returns the number behind the eyes, upright whichever way the agent looks."""
    side = size * FINE
    image = Image.new("RGBA", (side, side))
    row, col = DIRECTIONS[heading]
    font = ImageFont.load_default(side * (0.44 if number < 10 else 0.36))
    ink = PAPER if sum(w * c for w, c in zip((0.3, 0.59, 0.11), fill, strict=True)) < 150 else INK
    ink = mixed(ink, fill, 0.35) if held else ink
    centre = (side * (0.5 - 0.15 * col), side * (0.5 - 0.15 * row))
    ImageDraw.Draw(image).text(centre, str(number), fill=(*ink, 255), font=font, anchor="mm", stroke_width=FINE / 5)
    return image.resize((size, size), Image.Resampling.BOX)

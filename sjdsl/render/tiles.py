"""Draws the tile of a cell as pixels."""

from collections.abc import Iterator

import numpy as np

from sjdsl.render.colours import INK, PAPER, Colour, mixed
from sjdsl.render.drawings import BAR_STEPS, BARS, Drawing
from sjdsl.render.sprites import FILLING, draw_sprite, lay
from sjdsl.render.usual import Picture

EDGE = 0.12  # of a cell's side
BAR = 0.13
BODY, OBJECT, HALF, BADGE = 0.88, 0.74, 0.5, 0.42  # sides of sprites, as shares of a cell's side
BADGE_CORNERS = ((1, 1), (1, 0), (0, 1), (0, 0))  # row and column of the corner of each badge, in order
BADGE_INSIDE = 0.74  # of the disc that a badge lies on
GRIDDED = 8  # pixels from which on cells are told apart by lines


def draw_tile(drawing: Drawing, size: int) -> np.ndarray:
    """Returns a tile, `[size, size, 3]` uint8."""
    tile = np.full((size, size, 3), drawing.ground, np.uint8)
    filled = drawing.body is not None and drawing.body.sprite in ("wall", "water")
    if size >= GRIDDED and not filled:
        tile[-1, :] = tile[:, -1] = mixed(drawing.ground, INK, 0.08)
    if drawing.body is not None:
        _put(tile, drawing.body, 1.0 if drawing.body.sprite in FILLING else BODY, (0.5, 0.5))
    if drawing.edge is not None:
        width = max(1, round(size * EDGE))
        for part in (tile[:width], tile[-width:], tile[:, :width], tile[:, -width:]):
            part[...] = drawing.edge
    for picture, (side, centre) in zip(drawing.objects, slots(len(drawing.objects)), strict=False):
        _put(tile, picture, side, centre)
    for place, eighths in drawing.bars:
        _bar(tile, place, eighths)
    put_badges(tile, drawing.badges)
    return tile


def put_badges(tile: np.ndarray, badges: tuple[Picture, ...]) -> None:
    """Puts small sprites into the corners of a cell, in place."""
    for (top, left), badge in badges_at(badges, tile.shape[0]):
        lay(tile, badge, top, left)


def badges_at(badges: tuple[Picture, ...], size: int) -> Iterator[tuple[tuple[int, int], np.ndarray]]:
    """Yields top, left and pixels of small sprites in the corners of a cell: bottom right, bottom left, top right, top left."""
    side = max(3, round(size * BADGE))
    for picture, (row, col) in zip(badges, BADGE_CORNERS, strict=False):
        yield (row * (size - side), col * (size - side)), _badge(picture, side)


def _badge(picture: Picture, side: int) -> np.ndarray:
    """Returns a sprite on a pale disc, so that it is seen on any ground."""
    disc = draw_sprite("disc", PAPER, side)
    inner = max(2, round(side * BADGE_INSIDE))
    badge = disc.copy()
    edge = (side - inner) // 2
    lay(badge[..., :3], draw_sprite(picture.sprite, picture.colour, inner), edge, edge)
    return badge


def _put(tile: np.ndarray, picture: Picture, share: float, centre: tuple[float, float]) -> None:
    size = tile.shape[0]
    side = max(1, round(size * share))
    top, left = (min(max(0, round(size * c - side / 2)), size - side) for c in centre)
    lay(tile, draw_sprite(picture.sprite, picture.colour, side), top, left)


def slots(count: int) -> list[tuple[float, tuple[float, float]]]:
    """Returns side and centre of each of `count` objects: the middle, two halves, or four quarters."""
    if count == 1:
        return [(OBJECT, (0.5, 0.5))]
    if count == 2:
        return [(HALF, (0.5, 0.25)), (HALF, (0.5, 0.75))]
    return [(HALF, (row, col)) for row in (0.25, 0.75) for col in (0.25, 0.75)]


def _bar(tile: np.ndarray, place: int, eighths: int) -> None:
    """Draws a bar along one side of a cell: its length says how much, its colour and its side what."""
    size = tile.shape[0]
    width, length = max(1, round(size * BAR)), max(1, round(size * eighths / BAR_STEPS))
    sides = (tile[-width:, :length], tile[:width, :length], tile[-length:, :width], tile[-length:, -width:])
    sides[place][...] = BARS[place]


def tinted(pixels: np.ndarray, colour: Colour, share: float) -> np.ndarray:
    """Returns pixels with a share of a colour."""
    under = pixels.astype(np.float32)
    return np.round(under + (np.array(colour) - under) * share).astype(np.uint8)

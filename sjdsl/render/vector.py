"""Draws cells, agents and movers as SVG: what browsers show, and what pixels are made of."""

import re
from base64 import b64encode
from collections.abc import Sequence
from functools import cache, lru_cache
from importlib.resources import files
from math import ceil, sqrt

from sjdsl.render.appearance import BAR_STEPS, Beam, Drawing, Figure
from sjdsl.render.colours import BARS, COVERING, FILLING, INK, PAPER, Colour, hexadecimal, mixed
from sjdsl.render.usual import Picture
from sjdsl.runtime.actions import DIRECTIONS

# Pixels of a picture's side in browsers: sharp where a cell has 24 on a screen of double density.
SIZE = 48
# Shares of a cell's side: widths of frames and bars, sides of sprites.
EDGE = 0.12
BAR = 0.13
BEAM_EDGE = 0.09
BODY = 0.88
OBJECT = 0.74
BADGE = 0.42
SMALL_BADGE = 1 / 3  # where a cell has more badges than corners
CORNERS = 4
# Row and column of each badge of a cell, in order.
BADGE_CORNERS = ((1, 1), (1, 0), (0, 1), (0, 0), (1, 0.5), (0, 0.5), (0.5, 0), (0.5, 1))
# Row and column of an agent's badges, by its heading: behind it, never over its eyes.
BEHIND = (
    ((1, 1), (1, 0)),
    ((1, 0), (0, 0)),
    ((0, 0), (0, 1)),
    ((0, 1), (1, 1)),
)
BEAM_OPACITY = 0.45
BADGE_INSIDE = 0.74  # share of the disc that a badge lies on
GRIDDED = 8  # pixels of a cell from which on lines separate cells
PALE = 0.62  # how much of a held agent is white
DARK = 150  # brightness below which a number is written in white
PALER = (
    '<filter id="pale" color-interpolation-filters="sRGB"><feComponentTransfer>'
    + "".join(
        f'<feFunc{part} type="linear" slope="{1 - PALE / 2}" intercept="{PALE / 2}"/>'
        for part in "RGB"
    )
    + "</feComponentTransfer></filter>"
)
KEPT = 4096  # texts of cells in the cache, and as many of figures


@lru_cache(KEPT)
def vector_tile(drawing: Drawing, size: int = SIZE) -> str:
    """Returns the tile of a cell, as SVG of `size` pixels."""
    body = drawing.body
    parts = [_box(0, 0, size, size, drawing.ground)]
    if size >= GRIDDED and (body is None or body.sprite not in COVERING):
        line = mixed(drawing.ground, INK, 0.08)
        parts += [_box(0, size - 1, size, 1, line), _box(size - 1, 0, 1, size, line)]
    if body is not None:
        parts.append(_centred(body, 1.0 if body.sprite in FILLING else BODY, (0.5, 0.5), size))
    for depth, colour in enumerate((drawing.edge, *drawing.inner)):
        if colour is not None:
            parts += _frame(depth, colour, size)
    share, centres = _slots(len(drawing.objects))
    # A grid can have more places than there are objects.
    for picture, centre in zip(drawing.objects, centres, strict=False):
        parts.append(_centred(picture, share, centre, size))
    parts += [_bar(place, eighths, size) for place, eighths in drawing.bars]
    parts += _badges(drawing.badges, size, BADGE_CORNERS)
    return _svg(parts, size)


def _frame(depth: int, colour: Colour, size: int) -> list[str]:
    """Returns the sides of a frame; `depth` frames lie around it."""
    width = max(1, round(size * EDGE))
    near = depth * width
    side = size - 2 * near
    far = near + side - width
    return [
        _box(near, near, side, width, colour),
        _box(near, far, side, width, colour),
        _box(near, near, width, side, colour),
        _box(far, near, width, side, colour),
    ]


def _bar(place: int, eighths: int, size: int) -> str:
    """Returns a bar: its side and colour tell which number it is, its length how large it is."""
    depth, side = divmod(place, len(BARS))
    width = max(1, round(size * BAR))
    length = max(1, round(size * eighths / BAR_STEPS))
    near = depth * width
    far = size - near - width
    boxes = (
        (0, far, length, width),
        (0, near, length, width),
        (near, size - length, width, length),
        (far, size - length, width, length),
    )
    return _box(*boxes[side], BARS[side])


@lru_cache(KEPT)
def vector_figure(figure: Figure | Beam, ground: Colour | None = None, size: int = SIZE) -> str:
    """Returns an agent or a mover with what it carries, or a beam, as SVG of `size` pixels.

    Args:
      ground: the colour under it; None leaves the picture transparent.
    """
    parts = [] if ground is None else [_box(0, 0, size, size, ground)]
    if isinstance(figure, Beam):
        return _svg([*parts, *_beam(figure, size)], size)
    body = _sprite(figure.sprite, _figure_colour(figure), 0, 0, size)
    if figure.heading:
        body = f'<g transform="rotate({90 * figure.heading} {size / 2} {size / 2})">{body}</g>'
    if figure.held:  # its edge and eyes are paler, too
        parts.append(PALER)
        body = f'<g filter="url(#pale)">{body}</g>'
    parts.append(body)
    if figure.number is not None:
        x, y, height = (size * share for share in number_place(figure))
        parts.append(
            f'<text x="{x:g}" y="{y:g}" dy=".35em" text-anchor="middle" '
            f'font-family="sans-serif" font-weight="600" font-size="{height:g}" '
            f'fill="{hexadecimal(number_ink(figure))}">{figure.number}</text>'
        )
    parts += _badges(figure.badges, size, BEHIND[figure.heading])
    return _svg(parts, size)


def _beam(beam: Beam, size: int) -> list[str]:
    """Returns a marked cell: a transparent box, and a line where the beam ends."""
    width = max(1, round(size * BEAM_EDGE))
    far = size - width
    sides = (
        (0, 0, size, width),
        (far, 0, width, size),
        (0, far, size, width),
        (0, 0, width, size),
    )
    parts = [f'<g opacity="{BEAM_OPACITY}">{_box(0, 0, size, size, beam.fill)}</g>']
    for side, is_end in zip(sides, beam.sides, strict=True):
        if is_end:
            parts.append(_box(*side, beam.edge))
    return parts


def _figure_colour(figure: Figure) -> Colour:
    """Returns the colour that a figure is drawn in: a paler one if it can only stay."""
    return mixed(figure.colour, PAPER, PALE) if figure.held else figure.colour


def number_ink(figure: Figure) -> Colour:
    """Returns the colour of a figure's number: one that can be read on the figure."""
    fill = _figure_colour(figure)
    red, green, blue = fill
    brightness = 0.3 * red + 0.59 * green + 0.11 * blue
    ink = PAPER if brightness < DARK else INK
    return mixed(ink, fill, 0.35) if figure.held else ink


def number_place(figure: Figure) -> tuple[float, float, float]:
    """Returns x, y and height of a figure's number, as shares of its side.

    The number stands behind the eyes, whichever way the figure faces.
    """
    row, col = DIRECTIONS[figure.heading]
    has_one_digit = figure.number is None or figure.number < 10
    return 0.5 - 0.15 * col, 0.5 - 0.15 * row, 0.56 if has_one_digit else 0.4


def svg_url(svg: str) -> str:
    """Returns an SVG picture as a data URL."""
    return "data:image/svg+xml;base64," + b64encode(svg.encode()).decode("ascii")


def _svg(parts: list[str], size: int) -> str:
    """Returns a square picture of elements."""
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{size}" height="{size}" '
        f'viewBox="0 0 {size} {size}">{"".join(parts)}</svg>'
    )


def _sprite(name: str, colour: Colour, left: int, top: int, side: int) -> str:
    """Returns a sprite as an element; left, top, side in pixels."""
    return (
        f'<svg x="{left}" y="{top}" width="{side}" height="{side}" '
        f'viewBox="0 0 100 100">{_sprite_elements(name, hexadecimal(colour))}</svg>'
    )


@cache
def sprite_source(name: str) -> str:
    """Returns the SVG text of a sprite; `currentColor` stands where its colour goes."""
    return files("sjdsl.render").joinpath(f"sprites/{name}.svg").read_text(encoding="utf-8")


@cache
def _sprite_elements(name: str, colour: str) -> str:
    """Returns the elements of a sprite in a colour, in coordinates of 0 .. 100."""
    elements = re.sub(r"<svg\b[^>]*>|</svg>", "", sprite_source(name))
    return re.sub(r"\s*\n\s*", "", elements).replace("currentColor", colour)


def _centred(picture: Picture, share: float, centre: tuple[float, float], size: int) -> str:
    """Returns a picture around a point of a cell, or as near to it as the cell allows.

    Args:
      share: the picture's side, as a share of the cell's.
      centre: down and right, as shares of the cell's side.
      size: pixels of the cell's side.
    """
    side = max(1, round(size * share))
    top, left = (min(max(0, round(size * c - side / 2)), size - side) for c in centre)
    return _sprite(picture.sprite, picture.colour, left, top, side)


def _slots(count: int) -> tuple[float, list[tuple[float, float]]]:
    """Returns the side and the centres of `count` objects, as shares of a cell's side.

    One stands in the middle, two beside each other, more in a grid of 2 x 2, 3 x 3 and so on.
    """
    if count == 1:
        return OBJECT, [(0.5, 0.5)]
    if count == 2:
        return 0.5, [(0.5, 0.25), (0.5, 0.75)]
    across = max(2, ceil(sqrt(count)))
    middles = [(place + 0.5) / across for place in range(across)]
    return 1 / across, [(row, col) for row in middles for col in middles]


def _badges(
    badges: tuple[Picture, ...], size: int, corners: Sequence[tuple[float, float]]
) -> list[str]:
    """Returns small sprites along the edge of a cell, each on a pale disc to be seen anywhere."""
    side = max(3, round(size * (BADGE if len(badges) <= CORNERS else SMALL_BADGE)))
    inner = max(2, round(side * BADGE_INSIDE))
    edge = (side - inner) // 2
    parts = []
    for picture, (row, col) in zip(badges, corners, strict=False):  # some corners stay empty
        left = round(col * (size - side))
        top = round(row * (size - side))
        parts.append(_sprite("disc", PAPER, left, top, side))
        parts.append(_sprite(picture.sprite, picture.colour, left + edge, top + edge, inner))
    return parts


def _box(left: int, top: int, width: int, height: int, colour: Colour) -> str:
    """Returns a filled rectangle as an element, in pixels."""
    return (
        f'<rect x="{left}" y="{top}" width="{width}" height="{height}" '
        f'fill="{hexadecimal(colour)}"/>'
    )

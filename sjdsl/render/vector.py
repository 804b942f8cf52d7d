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

SIZE = 48  # pixels of a picture's side for browsers: sharp where a cell has 24 on a screen of double density
EDGE = 0.12  # of a cell's side
BAR = 0.13
BODY, OBJECT, HALF, BADGE = 0.88, 0.74, 0.5, 0.42  # sides of sprites, as shares of a cell's side
SMALL_BADGE = 1 / 3  # of more badges than there are corners
CORNERS = 4
BADGE_CORNERS = (
    (1, 1),
    (1, 0),
    (0, 1),
    (0, 0),
    (1, 0.5),
    (0, 0.5),
    (0.5, 0),
    (0.5, 1),
)  # row and column of each badge of a cell, in order
BEHIND = (
    ((1, 1), (1, 0)),
    ((1, 0), (0, 0)),
    ((0, 0), (0, 1)),
    ((0, 1), (1, 1)),
)  # of an agent, by its heading: never over its eyes
BEAM_OPACITY, BEAM_EDGE = 0.45, 0.09
BADGE_INSIDE = 0.74  # of the disc that a badge lies on
GRIDDED = 8  # pixels from which on cells are told apart by lines
NUMBER = 0.44, 0.36  # heights of numbers of one digit and of more, as shares of a cell's side
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
KEPT = 4096  # texts of cells, and as many of figures


@lru_cache(KEPT)
def vector_tile(drawing: Drawing, size: int = SIZE) -> str:
    """Returns the tile of a cell, as SVG of `size` pixels."""
    parts = [_box(0, 0, size, size, drawing.ground)]
    if size >= GRIDDED and (drawing.body is None or drawing.body.sprite not in COVERING):
        line = mixed(drawing.ground, INK, 0.08)
        parts += [_box(0, size - 1, size, 1, line), _box(size - 1, 0, 1, size, line)]
    if drawing.body is not None:
        parts.append(
            _placed(drawing.body, 1.0 if drawing.body.sprite in FILLING else BODY, (0.5, 0.5), size)
        )
    width = max(1, round(size * EDGE))
    for depth, colour in enumerate((drawing.edge, *drawing.inner)):
        if colour is not None:
            start, side = depth * width, size - 2 * depth * width
            far = start + side - width
            boxes = (
                (start, start, side, width),
                (start, far, side, width),
                (start, start, width, side),
                (far, start, width, side),
            )
            parts += [_box(*box, colour) for box in boxes]
    parts += [
        _placed(picture, *slot, size)
        for picture, slot in zip(drawing.objects, _slots(len(drawing.objects)), strict=False)
    ]
    width = max(1, round(size * BAR))
    for (
        place,
        eighths,
    ) in (
        drawing.bars
    ):  # the length of a bar says how much, its colour and its side what; further ones lie inside
        depth, side = divmod(place, len(BARS))
        length, near, far = (
            max(1, round(size * eighths / BAR_STEPS)),
            depth * width,
            size - (depth + 1) * width,
        )
        across, along = (length, width), (width, length)
        boxes = (
            (0, far, *across),
            (0, near, *across),
            (near, size - length, *along),
            (far, size - length, *along),
        )
        parts.append(_box(*boxes[side], BARS[side]))
    return _whole([*parts, *_badges(drawing.badges, size, BADGE_CORNERS)], size)


@lru_cache(KEPT)
def vector_figure(figure: Figure | Beam, ground: Colour | None = None, size: int = SIZE) -> str:
    """Returns an agent or a mover with what it carries, or a beam, as SVG of `size` pixels. `ground`: what lies under it; None for nothing."""
    parts = [] if ground is None else [_box(0, 0, size, size, ground)]
    if isinstance(figure, Beam):
        width = max(1, round(size * BEAM_EDGE))
        far = size - width
        boxes = (
            (0, 0, size, width),
            (far, 0, width, size),
            (0, far, size, width),
            (0, 0, width, size),
        )
        edges = [
            _box(*box, figure.edge) for box, side in zip(boxes, figure.sides, strict=True) if side
        ]
        return _whole(
            [
                *parts,
                f'<g opacity="{BEAM_OPACITY}">{_box(0, 0, size, size, figure.fill)}</g>',
                *edges,
            ],
            size,
        )
    body = _sprite(figure.sprite, _filling(figure), 0, 0, size)
    if figure.heading:
        body = f'<g transform="rotate({90 * figure.heading} {size / 2} {size / 2})">{body}</g>'
    if figure.held:  # its edge and eyes are paler, too
        parts.append(PALER)
        body = f'<g filter="url(#pale)">{body}</g>'
    parts.append(body)
    if figure.number is not None:
        x, y, height = (size * share for share in number_place(figure))
        parts.append(
            f'<text x="{x:g}" y="{y:g}" dy=".35em" text-anchor="middle" font-family="sans-serif" font-weight="600" '
            f'font-size="{height:g}" fill="{hexadecimal(number_ink(figure))}">{figure.number}</text>'
        )
    return _whole([*parts, *_badges(figure.badges, size, BEHIND[figure.heading])], size)


def _filling(figure: Figure) -> Colour:
    """Returns the colour that a figure is drawn in: a paler one if it can only stay."""
    return mixed(figure.colour, PAPER, PALE) if figure.held else figure.colour


def number_ink(figure: Figure) -> Colour:
    """Returns the colour in which a figure's number is read on it."""
    fill = _filling(figure)
    ink = PAPER if sum(w * c for w, c in zip((0.3, 0.59, 0.11), fill, strict=True)) < DARK else INK
    return mixed(ink, fill, 0.35) if figure.held else ink


def number_place(figure: Figure) -> tuple[float, float, float]:
    """Returns x, y and height of a figure's number, as shares of its side: behind the eyes, whichever way it looks."""
    row, col = DIRECTIONS[figure.heading]
    return 0.5 - 0.15 * col, 0.5 - 0.15 * row, NUMBER[(figure.number or 0) >= 10]


def svg_url(svg: str) -> str:
    """Returns a picture as a data URL."""
    return "data:image/svg+xml;base64," + b64encode(svg.encode()).decode("ascii")


def _whole(parts: list[str], size: int) -> str:
    return f'<svg xmlns="http://www.w3.org/2000/svg" width="{size}" height="{size}" viewBox="0 0 {size} {size}">{"".join(parts)}</svg>'


def _sprite(name: str, colour: Colour, left: int, top: int, side: int) -> str:
    return f'<svg x="{left}" y="{top}" width="{side}" height="{side}" viewBox="0 0 100 100">{_inside(name, hexadecimal(colour))}</svg>'


@cache
def sprite_source(name: str) -> str:
    """Returns the SVG text of a sprite; `currentColor` stands where its colour goes."""
    return files("sjdsl.render").joinpath(f"sprites/{name}.svg").read_text(encoding="utf-8")


@cache
def _inside(name: str, colour: str) -> str:
    """Returns what a sprite consists of, in a colour, in coordinates of 0 .. 100."""
    return re.sub(r"\s*\n\s*", "", re.sub(r"<svg\b[^>]*>|</svg>", "", sprite_source(name))).replace(
        "currentColor", colour
    )


def _placed(picture: Picture, share: float, centre: tuple[float, float], size: int) -> str:
    """Returns a picture whose side is `share` of a cell's, around `centre` (down and right, as shares of the cell) as far as it fits."""
    side = max(1, round(size * share))
    top, left = (min(max(0, round(size * c - side / 2)), size - side) for c in centre)
    return _sprite(picture.sprite, picture.colour, left, top, side)


def _slots(count: int) -> list[tuple[float, tuple[float, float]]]:
    """Returns side and centre of each of `count` objects: the middle, two halves, four quarters, nine ninths and so on."""
    if count == 1:
        return [(OBJECT, (0.5, 0.5))]
    if count == 2:
        return [(HALF, (0.5, 0.25)), (HALF, (0.5, 0.75))]
    across = max(2, ceil(sqrt(count)))
    middles = [(place + 0.5) / across for place in range(across)]
    return [(1 / across, (row, col)) for row in middles for col in middles]


def _badges(
    badges: tuple[Picture, ...], size: int, corners: Sequence[tuple[float, float]]
) -> list[str]:
    """Returns small sprites at the edges of a cell, each on a pale disc so that it is seen on any ground."""
    crowded = len(badges) > CORNERS
    side = max(3, round(size * (SMALL_BADGE if crowded else BADGE)))
    inner = max(2, round(side * BADGE_INSIDE))
    found = []
    for picture, (row, col) in zip(badges, corners, strict=False):
        left, top, edge = (
            round(col * (size - side)),
            round(row * (size - side)),
            (side - inner) // 2,
        )
        found.append(
            _sprite("disc", PAPER, left, top, side)
            + _sprite(picture.sprite, picture.colour, left + edge, top + edge, inner)
        )
    return found


def _box(left: int, top: int, width: int, height: int, colour: Colour) -> str:
    return f'<rect x="{left}" y="{top}" width="{width}" height="{height}" fill="{hexadecimal(colour)}"/>'

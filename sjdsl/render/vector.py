"""Draws cells, agents and movers as SVG, for browsers: the same parts in the same places as pixels have."""

import re
from base64 import b64encode
from functools import cache

from sjdsl.render.colours import INK, PAPER, Colour, mixed
from sjdsl.render.drawings import BAR_STEPS, BARS, PALE, Drawing, Figure
from sjdsl.render.sprites import FILLING, sprite_source
from sjdsl.render.tiles import BADGE, BADGE_CORNERS, BADGE_INSIDE, BAR, BODY, EDGE, slots
from sjdsl.render.usual import Picture
from sjdsl.runtime.actions import DIRECTIONS

SIZE = 48  # pixels of a picture's side: sharp where a cell has 24 on a screen of double density
NUMBER = 0.44, 0.36  # heights of numbers of one digit and of more, as shares of a cell's side
DARK = 150  # brightness below which a number is written in white
PALER = (
    '<filter id="pale" color-interpolation-filters="sRGB"><feComponentTransfer>'
    + "".join(f'<feFunc{part} type="linear" slope="{1 - PALE / 2}" intercept="{PALE / 2}"/>' for part in "RGB")
    + "</feComponentTransfer></filter>"
)
_OUTER = re.compile(r"<svg\b[^>]*>|</svg>")


def vector_tile(drawing: Drawing) -> str:
    """Returns the tile of a cell, as SVG of `SIZE` pixels."""
    parts = [_box(0, 0, SIZE, SIZE, drawing.ground)]
    if drawing.body is None or drawing.body.sprite not in ("wall", "water"):
        line = mixed(drawing.ground, INK, 0.08)
        parts += [_box(0, SIZE - 1, SIZE, 1, line), _box(SIZE - 1, 0, 1, SIZE, line)]
    if drawing.body is not None:
        parts.append(_placed(drawing.body, 1.0 if drawing.body.sprite in FILLING else BODY, (0.5, 0.5)))
    if drawing.edge is not None:
        width = round(SIZE * EDGE)
        inner = SIZE - width
        parts += [
            _box(*at, drawing.edge) for at in ((0, 0, SIZE, width), (0, inner, SIZE, width), (0, 0, width, SIZE), (inner, 0, width, SIZE))
        ]
    parts += [_placed(picture, *slot) for picture, slot in zip(drawing.objects, slots(len(drawing.objects)), strict=False)]
    parts += [_bar(place, eighths) for place, eighths in drawing.bars]
    return _whole([*parts, *_badges(drawing.badges)])


def vector_figure(figure: Figure, ground: Colour | None = None) -> str:
    """Returns an agent or a mover with what it carries, as SVG of `SIZE` pixels. `ground`: what lies under it; None for nothing."""
    fill = mixed(figure.colour, PAPER, PALE) if figure.held else figure.colour
    parts = [] if ground is None else [_box(0, 0, SIZE, SIZE, ground)]
    body = _sprite(figure.sprite, fill, 0, 0, SIZE)
    if figure.heading:
        body = f'<g transform="rotate({90 * figure.heading} {SIZE / 2} {SIZE / 2})">{body}</g>'
    if figure.held:  # its edge and eyes are paler, too
        parts.append(PALER)
        body = f'<g filter="url(#pale)">{body}</g>'
    parts.append(body)
    if figure.number is not None:
        parts.append(_number(figure.number, fill, figure.heading, figure.held))
    return _whole([*parts, *_badges(figure.badges)])


def svg_url(svg: str) -> str:
    """Returns a picture as a data URL."""
    return "data:image/svg+xml;base64," + b64encode(svg.encode()).decode("ascii")


def _whole(parts: list[str]) -> str:
    return f'<svg xmlns="http://www.w3.org/2000/svg" width="{SIZE}" height="{SIZE}" viewBox="0 0 {SIZE} {SIZE}">{"".join(parts)}</svg>'


def _sprite(name: str, colour: Colour, left: int, top: int, side: int) -> str:
    return f'<svg x="{left}" y="{top}" width="{side}" height="{side}" viewBox="0 0 100 100">{_inside(name, _css(colour))}</svg>'


@cache
def _inside(name: str, colour: str) -> str:
    """Returns what a sprite consists of, in a colour, in coordinates of 0 .. 100."""
    return re.sub(r"\s*\n\s*", "", _OUTER.sub("", sprite_source(name))).replace("currentColor", colour)


def _placed(picture: Picture, share: float, centre: tuple[float, float]) -> str:
    side = round(SIZE * share)
    top, left = (min(max(0, round(SIZE * c - side / 2)), SIZE - side) for c in centre)
    return _sprite(picture.sprite, picture.colour, left, top, side)


def _bar(place: int, eighths: int) -> str:
    width, length = round(SIZE * BAR), max(1, round(SIZE * eighths / BAR_STEPS))
    far = SIZE - width
    boxes = ((0, far, length, width), (0, 0, length, width), (0, SIZE - length, width, length), (far, SIZE - length, width, length))
    return _box(*boxes[place], BARS[place])


def _badges(badges: tuple[Picture, ...]) -> list[str]:
    """Returns small sprites in the corners of a cell, each on a pale disc so that it is seen on any ground."""
    side = round(SIZE * BADGE)
    inner = round(side * BADGE_INSIDE)
    found = []
    for picture, (row, col) in zip(badges, BADGE_CORNERS, strict=False):
        left, top, edge = col * (SIZE - side), row * (SIZE - side), (side - inner) // 2
        found.append(_sprite("disc", PAPER, left, top, side) + _sprite(picture.sprite, picture.colour, left + edge, top + edge, inner))
    return found


def _number(number: int, fill: Colour, heading: int, held: bool) -> str:
    """Returns the number behind the eyes, upright whichever way the agent looks."""
    row, col = DIRECTIONS[heading]
    ink = PAPER if sum(w * c for w, c in zip((0.3, 0.59, 0.11), fill, strict=True)) < DARK else INK
    ink = mixed(ink, fill, 0.35) if held else ink
    height = SIZE * NUMBER[number >= 10]
    x, y = SIZE * (0.5 - 0.15 * col), SIZE * (0.5 - 0.15 * row)
    return (
        f'<text x="{x:g}" y="{y:g}" dy=".35em" text-anchor="middle" font-family="sans-serif" font-weight="600" '
        f'font-size="{height:g}" fill="{_css(ink)}">{number}</text>'
    )


def _box(left: int, top: int, width: int, height: int, colour: Colour) -> str:
    return f'<rect x="{left}" y="{top}" width="{width}" height="{height}" fill="{_css(colour)}"/>'


def _css(colour: Colour) -> str:
    return "#{:02x}{:02x}{:02x}".format(*colour)

"""Tiles: the picture of one cell for each combination of kind and field values, drawn large and shrunk."""

from collections.abc import Callable

import numpy as np
from PIL import Image, ImageDraw

from sjdsl.render.colours import INK, Colour
from sjdsl.render.look import FieldLook, KindLook

FINE = 8  # a tile is drawn this many times larger, then shrunk
BAR_STEPS = 8
EDGE = 0.16  # of a cell's side
Box = tuple[float, float, float, float]


def mixed(first: Colour, second: Colour, share: float) -> Colour:
    """Returns `first` with a share (0 .. 1) of `second`."""
    return tuple(round(a + (b - a) * share) for a, b in zip(first, second, strict=True))  # type: ignore[return-value]


def draw_tile(kind: KindLook, values: tuple[int, ...], size: int) -> np.ndarray:
    """Returns a tile, `[size, size, 3]` uint8; `values` holds a number for each field: a word's, an agent's and 1, eighths of a bar."""
    ground = kind.colour
    for field, value in zip(kind.fields, values, strict=True):
        if field.sort == "tint" and field.is_drawn(value):
            ground = mixed(ground, field.colours[value], 0.4)
    side = size * FINE
    image = Image.new("RGB", (side, side), ground)
    pen = ImageDraw.Draw(image)
    if size >= 8 and not kind.solid:
        edge = mixed(ground, INK, 0.12)
        pen.rectangle((0, side - FINE, side, side), fill=edge)
        pen.rectangle((side - FINE, 0, side, side), fill=edge)
    for field, value in zip(kind.fields, values, strict=True):
        if field.sort == "edge" and value > 0:
            pen.rectangle((0, 0, side - 1, side - 1), outline=field.colours[value - 1], width=round(side * EDGE))
    shapes = [(f, v) for f, v in zip(kind.fields, values, strict=True) if f.sort == "shape"]
    for place, (field, value) in enumerate(shapes):
        if field.is_drawn(value):
            draw_shape(pen, value if value > 0 else len(field.words), field.colours[value], _slot(place, len(shapes), side))
    bars = [(f, v) for f, v in zip(kind.fields, values, strict=True) if f.sort == "bar" and v > 0]
    for place, (_, value) in enumerate(bars):
        low = side - (place + 1) * side / 7
        pen.rectangle((0, low, side * value / BAR_STEPS, low + side / 8.5), fill=mixed(INK, ground, 0.25))
    return np.asarray(image.resize((size, size), Image.Resampling.BOX))


def _slot(place: int, count: int, side: int) -> Box:
    """Returns where the shape of field number `place` of `count` is drawn: the middle, two halves, or four quarters."""
    if count == 1:
        return side * 0.2, side * 0.2, side * 0.8, side * 0.8
    row, col = (0.25, place) if count == 2 else divmod(place % 4, 2)
    left, top = side * (0.04 + 0.48 * col), side * (0.04 + 0.48 * row)
    return left, top, left + side * 0.44, top + side * 0.44


def draw_shape(pen: ImageDraw.ImageDraw, number: int, colour: Colour, box: Box) -> None:
    """Draws the shape of word `number` (from 1) of a field: colours alone would not do for everybody."""
    width = max(1, round((box[2] - box[0]) * 0.07))
    _SHAPES[(number - 1) % len(_SHAPES)](pen, box, colour, mixed(colour, INK, 0.55), width)


Draw = Callable[[ImageDraw.ImageDraw, Box, Colour, Colour, int], None]


def _circle(pen: ImageDraw.ImageDraw, box: Box, fill: Colour, edge: Colour, width: int) -> None:
    pen.ellipse(box, fill=fill, outline=edge, width=width)


def _ring(pen: ImageDraw.ImageDraw, box: Box, fill: Colour, edge: Colour, width: int) -> None:
    pen.ellipse(box, outline=edge, width=width * 4)
    inner = (box[0] + width, box[1] + width, box[2] - width, box[3] - width)
    pen.ellipse(inner, outline=fill, width=width * 3)


def _polygon(*points: tuple[float, float]) -> Draw:
    """Returns a way to draw the polygon with these corners, each coordinate from 0 to 1."""

    def draw(pen: ImageDraw.ImageDraw, box: Box, fill: Colour, edge: Colour, width: int) -> None:
        left, top, right, bottom = box
        pen.polygon([(left + x * (right - left), top + y * (bottom - top)) for x, y in points], fill, edge, width)

    return draw


_SHAPES: tuple[Draw, ...] = (
    _circle,
    _polygon((0.5, -0.08), (1.08, 0.5), (0.5, 1.08), (-0.08, 0.5)),
    _polygon((0.08, 0.08), (0.92, 0.08), (0.92, 0.92), (0.08, 0.92)),
    _polygon((0.5, 0.0), (1.0, 0.92), (0.0, 0.92)),
    _ring,
    _polygon(
        (0.33, 0), (0.67, 0), (0.67, 0.33), (1, 0.33), (1, 0.67), (0.67, 0.67),
        (0.67, 1), (0.33, 1), (0.33, 0.67), (0, 0.67), (0, 0.33), (0.33, 0.33),
    ),
    _polygon((0.25, 0.05), (0.75, 0.05), (1, 0.5), (0.75, 0.95), (0.25, 0.95), (0, 0.5)),
    _polygon((0.0, 0.08), (1.0, 0.08), (0.5, 1.0)),
)  # fmt: skip


def shown_values(field: FieldLook, values: np.ndarray) -> np.ndarray:
    """Returns `[S]` int: the number of each cell's word, of its agent and 1, or the eighths of its bar, rounded up."""
    match field.holds:
        case "word":
            return values.astype(int)
        case "agents":
            counts = np.bitwise_count(values)
        case "agent":
            return values.astype(int) + 1
        case _:
            counts = values.reshape(len(values), -1).sum(axis=1)
    return np.clip(np.ceil(counts / field.full * BAR_STEPS), 0, BAR_STEPS).astype(int)

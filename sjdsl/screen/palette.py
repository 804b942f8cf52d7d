"""Maps colours to the 256 colours of a terminal, each to a near one, and no two to the same."""

from collections.abc import Iterable, Sequence

import numpy as np

from sjdsl.render.colours import Colour

LEVELS = (0, 95, 135, 175, 215, 255)
# Numbers 16 to 255 of the terminals' table: a cube of six levels a channel, and a ramp of 24 greys.
# Source: xterm, 256colres.pl.
TABLE: tuple[Colour, ...] = (
    *((red, green, blue) for red in LEVELS for green in LEVELS for blue in LEVELS),
    *((8 + 10 * step,) * 3 for step in range(24)),
)
APART = 0.06  # in Oklab, where 0.02 is about the least difference that can be seen side by side
DARK, LIGHT = TABLE[0], (255, 255, 255)


def oklab(colours: Iterable[Colour]) -> np.ndarray:
    """Returns colours as `[n, 3]` float64 in a space where distance is about what is seen.

    Source: Björn Ottosson, "A perceptual color space for image processing", 2020.
    """
    channels = np.array(list(colours), float).reshape(-1, 3) / 255
    linear = np.where(channels <= 0.04045, channels / 12.92, ((channels + 0.055) / 1.055) ** 2.4)
    cones = np.cbrt(
        linear
        @ np.array(
            [
                [0.4122214708, 0.2119034982, 0.0883024619],
                [0.5363325363, 0.6806995451, 0.2817188376],
                [0.0514459929, 0.1073969566, 0.6299787005],
            ]
        )
    )
    axes = np.array(
        [
            [0.2104542553, 1.9779984951, 0.0259040371],
            [0.7936177850, -2.4285922050, 0.7827717662],
            [-0.0040720468, 0.4505937099, -0.8086757660],
        ]
    )
    return np.asarray(cones @ axes)


def told_apart(wanted: Sequence[Colour], taken: Sequence[Colour] = ()) -> list[Colour]:
    """Returns for each wanted colour the nearest of the terminal's that differs from those before it and from `taken`.

    Where so many are wanted that none is left at a distance, the one that is farthest from all others is taken.
    """
    table = oklab(TABLE)
    used = [oklab([colour])[0] for colour in taken]
    found = []
    for colour in wanted:
        away = np.min([np.linalg.norm(table - other, axis=1) for other in used], axis=0) if used else np.full(len(table), np.inf)
        near = np.linalg.norm(table - oklab([colour])[0], axis=1)
        best = int(np.argmin(np.where(away >= APART, near, np.inf))) if (away >= APART).any() else int(np.argmax(away))
        used.append(table[best])
        found.append(TABLE[best])
    return found


def ink_on(ground: Colour) -> Colour:
    """Returns black or white, whichever is easier to read on a colour."""
    return DARK if oklab([ground])[0, 0] > 0.6 else LIGHT


def faint_on(ground: Colour) -> Colour:
    """Returns an ink that can just be read on a colour, for what is everywhere."""
    ink, share = ink_on(ground), 0.35
    red, green, blue = (round(under + (over - under) * share) for under, over in zip(ground, ink, strict=True))
    return red, green, blue

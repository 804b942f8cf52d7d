"""Puts two films of equal size and length into one, in step, each under a line that says what it shows.

    python -m bench.side_by_side LEFT.gif RIGHT.gif "what is left" "what is right" -o BOTH.gif

The picture of README.md is made so from two films of `sjdsl render`.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path

from PIL import Image, ImageDraw, ImageSequence

from sjdsl.render.colours import INK, PAPER
from sjdsl.render.film import MILLISECONDS, save_gif
from sjdsl.render.status import FONT

GAP = 20  # pixels between the films
CAPTION = 26  # pixels above a film


def main() -> None:
    """Writes the film."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("films", nargs=2, type=Path, metavar="FILM.gif")
    parser.add_argument("captions", nargs=2, metavar="CAPTION")
    parser.add_argument("-o", "--output", type=Path, required=True)
    arguments = parser.parse_args()
    left, right = (frames_of(film) for film in arguments.films)
    save_gif(side_by_side(left, right, arguments.captions), arguments.output, MILLISECONDS)


def frames_of(film: Path) -> list[Image.Image]:
    """Returns the frames of a GIF."""
    with Image.open(film) as frames:
        return [frame.convert("RGB") for frame in ImageSequence.Iterator(frames)]


def side_by_side(
    left: Sequence[Image.Image], right: Sequence[Image.Image], captions: Sequence[str]
) -> list[Image.Image]:
    """Returns frames with both films. Raises ValueError if one has more frames."""
    width, height = left[0].size
    together = []
    for pair in zip(left, right, strict=True):
        frame = Image.new("RGB", (2 * width + GAP, height + CAPTION), PAPER)
        pen = ImageDraw.Draw(frame)
        for place, picture, caption in zip((0, width + GAP), pair, captions, strict=True):
            pen.text((place + 8, CAPTION // 2), caption, INK, FONT, anchor="lm", stroke_width=0.3)
            frame.paste(picture, (place, CAPTION))
        together.append(frame)
    return together


if __name__ == "__main__":
    main()

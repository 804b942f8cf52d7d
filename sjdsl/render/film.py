"""Draws the frames of a film, and writes frames as GIF, MP4 or PNG.

A frame is a board with the state of the agents and the legend below.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import numpy as np

from sjdsl.extras import needs
from sjdsl.files import written_whole
from sjdsl.render.appearance import Drawing
from sjdsl.render.board import draw_board, draw_tile, put_figure
from sjdsl.render.colours import INK, OUTSIDE, PAPER
from sjdsl.render.legend import legend_entries
from sjdsl.render.look import Look, make_look
from sjdsl.render.moment import Moment, Snapshot
from sjdsl.render.status import FONT, GAP, LINE, MARGIN, SWATCH, Status, make_status
from sjdsl.runtime.env import Environment

with needs("pictures"):
    from PIL import Image, ImageDraw
    from PIL.PngImagePlugin import PngInfo

MIN_WIDTH = 400
MILLISECONDS = 120  # for which a frame is shown
SAMPLES = 24  # frames whose colours make the palette
COLOURS = 200  # of the palette; leaves room for the one that means "as before"


@dataclass(frozen=True)
class Painter:
    """Draws the frames of one game. Its legend has been drawn once, for all of them."""

    look: Look
    width: int
    status: Status
    legend: Image.Image

    def draw(
        self, snapshot: Snapshot, actions: Sequence[int] = (), before: Snapshot | None = None
    ) -> Image.Image:
        """Returns the picture of one moment; all pictures of a painter have the same size.

        Args:
          actions: the number of each agent's action in the last step, if they are known. They tell
            which agent's colour a beam has.
          before: the moment before, for what was taken, cleaned or hit since then to flash.
        """
        board = Image.fromarray(draw_board(self.look, snapshot, actions, before))
        status = self.status.draw(snapshot)
        legend_top = board.height + status.height
        picture = Image.new("RGB", (self.width, legend_top + self.legend.height), OUTSIDE)
        picture.paste(board, ((self.width - board.width) // 2, 0))
        picture.paste(status, (0, board.height))
        picture.paste(self.legend, (0, legend_top))
        return picture


def make_painter(env: Environment, shown: Sequence[Snapshot] | None = None) -> Painter:
    """Returns what draws the states of an environment.

    Args:
      shown: the moments that will be drawn; the legend leaves out what is in none of them.
    """
    look = make_look(env.game)
    width = max(look.width * look.tile, MIN_WIDTH)
    return Painter(look, width, make_status(look, width, shown), draw_legend(look, width, shown))


def draw_film(env: Environment, moments: Iterable[Moment]) -> Iterator[Image.Image]:
    """Yields the picture of each moment."""
    moments = list(moments)
    painter = make_painter(env, [moment.snapshot for moment in moments])
    before: Snapshot | None = None
    for moment in moments:
        yield painter.draw(moment.snapshot, moment.actions, before)
        before = moment.snapshot


def draw_legend(look: Look, width: int, shown: Sequence[Snapshot] | None = None) -> Image.Image:
    """Returns the part of the picture that is the same in every frame: the legend."""
    lines: list[list[tuple[int, np.ndarray, str]]] = [[]]  # left edge, picture, text
    left = MARGIN
    for symbol, text in legend_entries(look, shown):
        if isinstance(symbol, Drawing):
            swatch = draw_tile(symbol, SWATCH)
        else:
            swatch = np.full((SWATCH, SWATCH, 3), PAPER, np.uint8)
            put_figure(swatch, symbol)
        length = SWATCH + 4 + round(FONT.getlength(text))
        if lines[-1] and left + length > width - MARGIN:
            lines.append([])
            left = MARGIN
        lines[-1].append((left, swatch, text))
        left += length + GAP
    strip = Image.new("RGB", (width, LINE * len(lines) + 4), PAPER)
    pen = ImageDraw.Draw(strip)
    for number, line in enumerate(lines):
        top = number * LINE + 2
        for left, swatch, text in line:
            strip.paste(Image.fromarray(swatch), (left, top))
            pen.text((left + SWATCH + 4, top + SWATCH // 2), text, INK, FONT, anchor="lm")
    return strip


def save_gif(
    frames: Sequence[Image.Image], path: Path | str, milliseconds: int = MILLISECONDS
) -> None:
    """Writes frames as an endless GIF; with one palette, so that nothing flickers.

    Args:
      milliseconds: for which a frame is shown; the last one stays eight times as long.
    """
    palette = _palette(frames)
    first, *others = [frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
    durations = [milliseconds] * len(others) + [8 * milliseconds]
    with written_whole(Path(path)) as file:
        first.save(
            file,
            format="GIF",
            save_all=True,
            append_images=others,
            duration=durations,
            loop=0,
            optimize=True,
        )


def save_mp4(
    frames: Sequence[Image.Image], path: Path | str, milliseconds: int = MILLISECONDS
) -> None:
    """Writes frames as an H.264 film.

    Raises:
      ModuleNotFoundError: the package `av` (`sjdsl[video]`) isn't installed.
    """
    with needs("video"):
        import av

    width, height = (2 * (side // 2) for side in frames[0].size)  # H.264 needs even sides
    with written_whole(Path(path)) as file, av.open(file, "w", format="mp4") as film:
        stream = film.add_stream("libx264", rate=Fraction(1000, milliseconds))
        stream.width = width
        stream.height = height
        stream.pix_fmt = "yuv420p"
        for frame in frames:
            picture = frame.convert("RGB").crop((0, 0, width, height))
            film.mux(stream.encode(av.VideoFrame.from_image(picture)))
        film.mux(stream.encode())


def save_png(frame: Image.Image, path: Path | str, notes: Mapping[str, str] | None = None) -> None:
    """Writes one picture; `notes` are stored in the file as texts by key."""
    texts = PngInfo()
    for key, note in (notes or {}).items():
        texts.add_text(key, note)
    with written_whole(Path(path)) as file:
        frame.save(file, format="PNG", optimize=True, pnginfo=texts)


def _palette(frames: Sequence[Image.Image]) -> Image.Image:
    """Returns a palette for all frames, from a sample of them side by side."""
    chosen = frames[:: max(1, len(frames) // SAMPLES)]
    width, height = frames[0].size
    sheet = Image.new("RGB", (width, height * len(chosen)))
    for number, frame in enumerate(chosen):
        sheet.paste(frame, (0, number * height))
    return sheet.quantize(COLOURS, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)

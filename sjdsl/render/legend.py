"""Draws the legend below the board: names of what is shown, rewards, and the number of the step."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from sjdsl.extras import needs
from sjdsl.render.colours import INK, PAPER
from sjdsl.render.drawings import Drawing, draw_figures
from sjdsl.render.entries import cell_entries, figure_entries
from sjdsl.render.look import Look
from sjdsl.render.snapshot import Snapshot
from sjdsl.render.tiles import draw_figure, draw_tile, put_figure, tinted

with needs("pictures"):
    from PIL import Image, ImageDraw, ImageFont

LINE, SWATCH, GAP, MARGIN = 23, 19, 14, 8  # pixels
FONT = ImageFont.load_default(12.5)
MIN_WIDTH = 400


@dataclass(frozen=True)
class Entry:
    """A swatch with its text."""

    picture: np.ndarray  # [SWATCH, SWATCH, 3] uint8
    text: str

    @property
    def width(self) -> int:
        return SWATCH + 4 + round(FONT.getlength(self.text)) + GAP


def draw_legend(look: Look, width: int) -> Image.Image:
    """Returns the part of the strip that is the same in every frame: the kinds, the words of their fields, the marks."""
    lines = list(_wrap(legend_entries(look), width - 2 * MARGIN))
    strip = Image.new("RGB", (width, LINE * len(lines) + 4), PAPER)
    pen = ImageDraw.Draw(strip)
    for number, line in enumerate(lines):
        left = MARGIN
        for entry in line:
            strip.paste(Image.fromarray(entry.picture), (left, number * LINE + 2))
            pen.text((left + SWATCH + 4, number * LINE + 2 + SWATCH // 2), entry.text, INK, FONT, anchor="lm")
            left += entry.width
    return strip


def draw_status(look: Look, snapshot: Snapshot, width: int) -> Image.Image:
    """Returns the part that changes: the step, and the rewards of each agent so far."""
    chips = [(number, f"{total:.4g}") for number, total in enumerate(snapshot.returns)]
    chip = SWATCH + 4 + max(30, round(max(FONT.getlength(text) for _, text in chips))) + GAP
    per_line = max(1, (width - 2 * MARGIN) // chip)
    lines = -(-len(chips) // per_line)
    strip = Image.new("RGB", (width, LINE * (1 + lines) + 4), PAPER)
    pen = ImageDraw.Draw(strip)
    pen.text((MARGIN, LINE // 2 + 2), look.title, INK, FONT, anchor="lm", stroke_width=0.3)
    pen.text((width - MARGIN, LINE // 2 + 2), f"step {snapshot.step}", INK, FONT, anchor="rm")
    figures = draw_figures(look, snapshot.values, np.zeros(look.num_agents, int), snapshot.held)
    for number, text in chips:
        line, place = divmod(number, per_line)
        left, top = MARGIN + place * chip, LINE * (1 + line) + 4
        body = Image.fromarray(draw_figure(replace(figures[number], badges=()), SWATCH))
        strip.paste(body, (left, top), body)
        pen.text((left + SWATCH + 4, top + SWATCH // 2), text, INK, FONT, anchor="lm")
    return strip


def _wrap(entries: Iterator[Entry], width: int) -> Iterator[list[Entry]]:
    """Yields the entries in lines that are not wider than `width`."""
    line: list[Entry] = []
    for entry in entries:
        if line and sum(e.width for e in line) + entry.width - GAP > width:
            yield line
            line = []
        line.append(entry)
    if line:
        yield line


def legend_entries(look: Look) -> Iterator[Entry]:
    for drawing, text in cell_entries(look):
        yield Entry(draw_tile(drawing, SWATCH), text)
    for label, colour in look.marks:
        ground = draw_tile(Drawing(look.kinds[0].ground), SWATCH)
        yield Entry(tinted(ground, colour, 0.6), label)
    for figure, text in figure_entries(look):
        swatch = np.full((SWATCH, SWATCH, 3), PAPER, np.uint8)
        put_figure(swatch, figure)
        yield Entry(swatch, text)

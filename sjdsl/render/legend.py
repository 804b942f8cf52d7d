"""The legend: a strip below the board that says what is what, who has earned how much, and which step it is."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from sjdsl.render.agents import draw_agent
from sjdsl.render.colours import INK, PAPER, Colour
from sjdsl.render.look import KindLook, Look
from sjdsl.render.snapshot import Snapshot
from sjdsl.render.tiles import draw_tile, mixed

LINE, SWATCH, GAP, MARGIN = 20, 15, 14, 8  # pixels
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
    lines = list(_wrap(_entries(look), width - 2 * MARGIN))
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
    chips = [(number, f"{number}:  {total:.4g}") for number, total in enumerate(snapshot.returns)]
    chip = SWATCH + 4 + max(44, round(max(FONT.getlength(text) for _, text in chips))) + GAP
    per_line = max(1, (width - 2 * MARGIN) // chip)
    lines = -(-len(chips) // per_line)
    strip = Image.new("RGB", (width, LINE * (1 + lines) + 4), PAPER)
    pen = ImageDraw.Draw(strip)
    pen.text((MARGIN, LINE // 2 + 2), look.title, INK, FONT, anchor="lm", stroke_width=0.3)
    pen.text((width - MARGIN, LINE // 2 + 2), f"step {snapshot.step}", INK, FONT, anchor="rm")
    colours = look.agent_colours(snapshot.values)
    for number, text in chips:
        line, place = divmod(number, per_line)
        left, top = MARGIN + place * chip, LINE * (1 + line) + 4
        picture = Image.fromarray(draw_agent(number, colours[number], 0, SWATCH + 3, bool(snapshot.held[number])))
        strip.paste(picture, (left, top - 2), picture)
        pen.text((left + SWATCH + 6, top + SWATCH // 2), text, INK, FONT, anchor="lm")
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


def _entries(look: Look) -> Iterator[Entry]:
    for kind in look.kinds:
        yield Entry(draw_tile(kind, (0,) * len(kind.fields), SWATCH), kind.name)
        yield from _field_entries(kind)
    for label, _, colour in look.marks:
        yield Entry(_plain(mixed((236, 234, 228), colour, 0.6)), label)
    for number, role in enumerate(look.roles):
        assert look.colour_field is not None
        yield Entry(_agent(look.colour_field[1][number]), role)
    if look.can_be_held:
        yield Entry(_agent((0, 114, 178), held=True), "pale: can only stay")


def _field_entries(kind: KindLook) -> Iterator[Entry]:
    for place, field in enumerate(kind.fields):
        if field.sort in ("bar", "edge"):
            yield Entry(_with(kind, place, 5 if field.sort == "bar" else 1), field.name)
        for number, word in enumerate(field.words):
            if field.is_drawn(number):
                yield Entry(_with(kind, place, number), word)


def _with(kind: KindLook, place: int, value: int) -> np.ndarray:
    """Returns the tile of a kind with a value of one field, the others plain."""
    values = [0] * len(kind.fields)
    values[place] = value
    return draw_tile(kind, tuple(values), SWATCH)


def _plain(colour: Colour) -> np.ndarray:
    return np.full((SWATCH, SWATCH, 3), colour, np.uint8)


def _agent(colour: Colour, held: bool = False) -> np.ndarray:
    picture = Image.new("RGB", (SWATCH, SWATCH), PAPER)
    over = Image.fromarray(draw_agent(0, colour, 0, SWATCH - 2, held))
    picture.paste(over, (1, 1), over)
    return np.asarray(picture)

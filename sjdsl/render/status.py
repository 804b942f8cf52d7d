"""Draws the part below the board that changes: the step, the world, and for each agent its rewards so far and what it has.

Where everything stands is decided once for all pictures of a game, from the widest texts in the moments that will be drawn. A text that is wider
still is drawn smaller, so that all pictures have one size.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from sjdsl.extras import needs
from sjdsl.render.appearance import Figure, draw_figures
from sjdsl.render.board import draw_figure
from sjdsl.render.colours import INK, PAPER, mixed
from sjdsl.render.look import FieldLook, Look
from sjdsl.render.moment import Snapshot
from sjdsl.render.readings import Reading

with needs("pictures"):
    from PIL import Image, ImageDraw, ImageFont

LINE, SWATCH, GAP, MARGIN = 23, 19, 14, 8  # pixels
SMALL, BETWEEN = 15, 4  # pixels of the picture of what an agent has; between a picture and its text
LEAST, UNKNOWN = 30, 60  # pixels of a return; of a text where no moment is known
FONT_SIZE = 12.5
FONT = ImageFont.load_default(FONT_SIZE)
FAINT = mixed(INK, PAPER, 0.4)  # of labels


@dataclass(frozen=True)
class Item:
    """What stands in one place: a picture, a label, and a text that changes, for which `room` pixels are kept."""

    room: int
    label: str = ""
    reading: Reading | None = None
    row: FieldLook | None = None
    entry: int = 0

    @property
    def width(self) -> int:
        picture = 0 if self.row is None else SMALL + BETWEEN
        label = round(FONT.getlength(self.label)) + BETWEEN if self.label else 0
        return picture + label + self.room

    def text(self, snapshot: Snapshot, agent: int | None) -> str:
        """Returns what changes."""
        if self.reading is not None:
            return self.reading.text(snapshot, agent)
        assert agent is not None
        if self.row is None:
            return f"{snapshot.returns[agent]:.4g}"
        return f"{snapshot.values[self.row.attribute][agent][self.entry]:.3g}"


@dataclass(frozen=True)
class Status:
    """Where everything stands. world, own: items with their left edge and their line, of the world and of one agent; per_line: agents in a line."""

    look: Look
    width: int
    world: tuple[tuple[Item, int, int], ...]
    own: tuple[tuple[Item, int, int], ...]
    column: int
    per_line: int

    @property
    def height(self) -> int:
        """Pixels of the strip."""
        rows = -(-self.look.num_agents // self.per_line)
        return LINE * (1 + lines_of(self.world) + rows * lines_of(self.own)) + 4

    def draw(self, snapshot: Snapshot) -> Image.Image:
        """Returns the strip for one moment."""
        strip = Image.new("RGB", (self.width, self.height), PAPER)
        pen = ImageDraw.Draw(strip)
        step = f"step {snapshot.step}"
        room = self.width - 2 * MARGIN - round(FONT.getlength(step)) - GAP
        write(pen, self.look.title, (MARGIN, LINE // 2 + 2), room, bold=True)
        pen.text((self.width - MARGIN, LINE // 2 + 2), step, INK, FONT, anchor="rm")
        for item, left, line in self.world:
            _put(strip, pen, item, item.text(snapshot, None), MARGIN + left, LINE * (1 + line) + 4)
        top = LINE * (1 + lines_of(self.world)) + 4
        for agent, figure in enumerate(draw_figures(self.look, snapshot)["agent"]):
            row, place = divmod(agent, self.per_line)
            start, above = MARGIN + place * self.column, top + row * LINE * lines_of(self.own)
            body = Image.fromarray(draw_figure(replace(figure, heading=0, badges=()), SWATCH))
            strip.paste(body, (start, above), body)
            for item, left, line in self.own:
                _put(
                    strip,
                    pen,
                    item,
                    item.text(snapshot, agent),
                    start + SWATCH + BETWEEN + left,
                    above + LINE * line,
                )
        return strip


def make_status(look: Look, width: int, shown: Sequence[Snapshot] | None = None) -> Status:
    """Returns the part below the board for all pictures of a game. `shown`: the moments that will be drawn, if they are known."""
    agents = range(look.num_agents)

    def item(agents: Sequence[int | None], least: int, unknown: int, **what: object) -> Item:
        blank = Item(0, **what)  # type: ignore[arg-type]
        texts = [blank.text(shot, agent) for shot in shown or () for agent in agents]
        widest = max(map(FONT.getlength, texts)) if texts else unknown
        return replace(blank, room=max(least, round(widest)))

    world = [
        item([None], 0, UNKNOWN, label=reading.name, reading=reading) for reading in look.world
    ]
    own = [item(agents, LEAST, LEAST)]
    for row in look.held:
        for entry in range(len(row.words)):
            own.append(
                item(
                    agents,
                    LEAST - BETWEEN,
                    LEAST - BETWEEN,
                    label="" if entry else row.name,
                    row=row,
                    entry=entry,
                )
            )
    own += [item(agents, 0, LEAST, label=reading.name, reading=reading) for reading in look.own]
    room = width - 2 * MARGIN - SWATCH - BETWEEN
    placed = tuple(flow(own, room))
    column = SWATCH + BETWEEN + max(left + item.width for item, left, _ in placed) + GAP
    per_line = max(1, (width - 2 * MARGIN) // column)
    return Status(look, width, tuple(flow(world, width - 2 * MARGIN)), placed, column, per_line)


def flow(items: Sequence[Item], width: int) -> Iterator[tuple[Item, int, int]]:
    """Yields items with their left edge and their line: as many in a line as `width` pixels hold."""
    left, line = 0, 0
    for item in items:
        if left and left + item.width > width:
            left, line = 0, line + 1
        yield item, left, line
        left += item.width + GAP // 2


def lines_of(placed: Sequence[tuple[Item, int, int]]) -> int:
    """Returns how many lines items take."""
    return max((line + 1 for _, _, line in placed), default=0)


def write(
    pen: ImageDraw.ImageDraw, text: str, at: tuple[int, int], room: int, bold: bool = False
) -> None:
    """Writes a text to the right of a point, smaller if it is wider than `room` pixels."""
    length = FONT.getlength(text)
    font = (
        FONT
        if length <= max(1, room)
        else ImageFont.load_default(max(1.0, FONT_SIZE * room / length))
    )
    pen.text(at, text, INK, font, anchor="lm", stroke_width=0.3 if bold else 0)


def _put(
    strip: Image.Image, pen: ImageDraw.ImageDraw, item: Item, text: str, left: int, top: int
) -> None:
    """Draws an item from its top left corner on."""
    middle = top + SWATCH // 2
    if item.label:
        pen.text((left, middle), item.label, FAINT, FONT, anchor="lm")
        left += round(FONT.getlength(item.label)) + BETWEEN
    if item.row is not None:
        picture = item.row.pictures[item.entry]
        thing = Image.fromarray(draw_figure(Figure(None, picture.colour, picture.sprite), SMALL))
        strip.paste(thing, (left, top + (SWATCH - SMALL) // 2), thing)
        left += SMALL + BETWEEN
    write(pen, text, (left, middle), item.room)

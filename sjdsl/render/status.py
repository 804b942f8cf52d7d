"""Draws what changes below the board: the step, the world, each agent's return and possessions.

The layout is the same in all pictures of a game. It follows from the widest texts in the moments
that will be drawn; a text that is wider still is drawn smaller.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import ceil

from sjdsl.extras import needs
from sjdsl.render.appearance import Figure, draw_figures
from sjdsl.render.board import draw_figure
from sjdsl.render.colours import INK, PAPER, mixed
from sjdsl.render.look import FieldLook, Look
from sjdsl.render.moment import Snapshot
from sjdsl.render.readings import Reading

with needs("pictures"):
    from PIL import Image, ImageDraw, ImageFont

# In pixels.
LINE = 23
SWATCH = 19
GAP = 14
MARGIN = 8
SMALL = 15  # side of the picture of what an agent has
BETWEEN = 4  # from a picture to its text
NUMBER_WIDTH = 30  # at least, for a return
UNKNOWN_WIDTH = 60  # for a text of the world if no moment is known
FONT_SIZE = 12.5
FONT = ImageFont.load_default(FONT_SIZE)
FAINT = mixed(INK, PAPER, 0.4)  # of labels
FADED = 0.5  # how much of an agent that is away is paper


@dataclass(frozen=True)
class Item:
    """A value below the board: a label, a picture or none, and a text of up to `room` pixels.

    The value is a reading, or an entry of an indexed field of agents, or else an agent's return.
    """

    room: int = 0
    label: str = ""
    reading: Reading | None = None
    field: FieldLook | None = None
    entry: int = 0

    @property
    def width(self) -> int:
        """Pixels of all parts together."""
        picture = 0 if self.field is None else SMALL + BETWEEN
        label = round(FONT.getlength(self.label)) + BETWEEN if self.label else 0
        return picture + label + self.room

    def text(self, snapshot: Snapshot, agent: int | None) -> str:
        """Returns the value at one moment. `agent`: whose it is, None for one of the world."""
        if self.reading is not None:
            return self.reading.text(snapshot, agent)
        assert agent is not None
        if self.field is None:
            return f"{snapshot.returns[agent]:.4g}"
        return f"{snapshot.values[self.field.attribute][agent][self.entry]:.3g}"


@dataclass(frozen=True)
class Placed:
    """An item, with its left edge in pixels and its line."""

    item: Item
    left: int
    line: int


@dataclass(frozen=True)
class Status:
    """The layout below the board.

    width: pixels; world, agent: items of the world and of one agent; column: pixels between agents;
    per_line: agents in a line.
    """

    look: Look
    width: int
    world: tuple[Placed, ...]
    agent: tuple[Placed, ...]
    column: int
    per_line: int

    @property
    def height(self) -> int:
        """Pixels of the picture."""
        rows = ceil(self.look.num_agents / self.per_line)
        return LINE * (1 + _count_lines(self.world) + rows * _count_lines(self.agent)) + 4

    def draw(self, snapshot: Snapshot) -> Image.Image:
        """Returns the picture of one moment."""
        picture = Image.new("RGB", (self.width, self.height), PAPER)
        pen = ImageDraw.Draw(picture)
        middle = LINE // 2 + 2
        step = f"step {snapshot.step}"
        room = self.width - 2 * MARGIN - round(FONT.getlength(step)) - GAP
        _write(pen, self.look.title, (MARGIN, middle), room, bold=True)
        pen.text((self.width - MARGIN, middle), step, INK, FONT, anchor="rm")
        for placed in self.world:
            text = placed.item.text(snapshot, None)
            top = LINE * (1 + placed.line) + 4
            _draw_item(picture, placed.item, text, MARGIN + placed.left, top)
        agents_top = LINE * (1 + _count_lines(self.world)) + 4
        for agent, figure in enumerate(draw_figures(self.look, snapshot)["agent"]):
            row, place = divmod(agent, self.per_line)
            left = MARGIN + place * self.column
            top = agents_top + row * LINE * _count_lines(self.agent)
            portrait = draw_figure(replace(figure, heading=0, badges=()), SWATCH)
            body = Image.fromarray(portrait)
            picture.paste(body, (left, top), body)
            items_left = left + SWATCH + BETWEEN
            for placed in self.agent:
                text = placed.item.text(snapshot, agent)
                item_top = top + LINE * placed.line
                _draw_item(picture, placed.item, text, items_left + placed.left, item_top)
            if snapshot.row[agent] < 0:
                bottom = top + LINE * _count_lines(self.agent)
                _fade(picture, (left, top, left + self.column - GAP, bottom))
        return picture


def make_status(look: Look, width: int, shown: Sequence[Snapshot] | None = None) -> Status:
    """Returns the layout for all pictures of a game.

    Args:
      width: pixels.
      shown: the moments that will be drawn, if they are known.
    """
    agents = range(look.num_agents)

    def sized(item: Item, agents: Sequence[int | None], unknown: int = 0, least: int = 0) -> Item:
        """Returns an item with room for its widest text, `unknown` pixels if no moment is known."""
        texts = [item.text(snapshot, agent) for snapshot in shown or () for agent in agents]
        widest = round(max(map(FONT.getlength, texts))) if texts else unknown
        return replace(item, room=max(least, widest))

    world: list[Item] = []
    for reading in look.world:
        item = Item(label=reading.name, reading=reading)
        world.append(sized(item, [None], UNKNOWN_WIDTH))
    of_agent = [sized(Item(), agents, least=NUMBER_WIDTH)]
    for field in look.possessions:
        for entry in range(len(field.words)):
            item = Item(label="" if entry else field.name, field=field, entry=entry)
            of_agent.append(sized(item, agents, least=NUMBER_WIDTH - BETWEEN))
    for reading in look.own:
        item = Item(label=reading.name, reading=reading)
        of_agent.append(sized(item, agents, NUMBER_WIDTH))
    line = width - 2 * MARGIN
    placed = tuple(_flow(of_agent, line - SWATCH - BETWEEN))
    right_edge = max(p.left + p.item.width for p in placed)
    column = SWATCH + BETWEEN + right_edge + GAP
    per_line = max(1, line // column)
    return Status(look, width, tuple(_flow(world, line)), placed, column, per_line)


def _flow(items: Sequence[Item], width: int) -> Iterator[Placed]:
    """Yields items with as many in a line as `width` pixels hold."""
    left = 0
    line = 0
    for item in items:
        if left and left + item.width > width:
            left = 0
            line += 1
        yield Placed(item, left, line)
        left += item.width + GAP // 2


def _count_lines(items: Sequence[Placed]) -> int:
    return max((placed.line + 1 for placed in items), default=0)


def _write(
    pen: ImageDraw.ImageDraw, text: str, point: tuple[int, int], room: int, bold: bool = False
) -> None:
    """Writes a text to the right of a point, smaller if it is wider than `room` pixels."""
    font = FONT
    length = FONT.getlength(text)
    if length > max(1, room):
        font = ImageFont.load_default(max(1.0, FONT_SIZE * room / length))
    pen.text(point, text, INK, font, anchor="lm", stroke_width=0.3 if bold else 0)


def _fade(picture: Image.Image, box: tuple[int, int, int, int]) -> None:
    """Makes a part of a picture grey and pale."""
    grey = picture.crop(box).convert("L").convert("RGB")
    picture.paste(Image.blend(grey, Image.new("RGB", grey.size, PAPER), FADED), box)


def _draw_item(picture: Image.Image, item: Item, text: str, left: int, top: int) -> None:
    """Draws an item from its top left corner on."""
    pen = ImageDraw.Draw(picture)
    middle = top + SWATCH // 2
    if item.label:
        pen.text((left, middle), item.label, FAINT, FONT, anchor="lm")
        left += round(FONT.getlength(item.label)) + BETWEEN
    if item.field is not None:
        symbol = item.field.pictures[item.entry]
        thing = Image.fromarray(draw_figure(Figure(None, symbol.colour, symbol.sprite), SMALL))
        picture.paste(thing, (left, top + (SWATCH - SMALL) // 2), thing)
        left += SMALL + BETWEEN
    _write(pen, text, (left, middle), item.room)

"""How a game looks: everything about its pictures that does not change from step to step."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np

from sjdsl.compiler import ir
from sjdsl.render.colours import COLOURS, WORDS, Colour, agent_colour, kind_colours, mark_colours, word_colours
from sjdsl.runtime.env import Environment

MAX_WIDTH, MAX_HEIGHT = 800, 600  # pixels of the board
MIN_TILE, MAX_TILE = 2, 40
TIMER_BAR = 10.0  # steps that fill the bar of a timer


@dataclass(frozen=True)
class FieldLook:
    """A field of a kind.

    sort: a word is a `shape` if rules change it, else a `tint`; an agent is an `edge` of its colour; all that can be counted is a
    `bar`, and `full` fills it.
    holds: `word`, `number`, `agent` (an id, -1 for nobody) or `agents` (bits).
    """

    name: str
    attribute: str
    sort: Literal["shape", "tint", "edge", "bar"]
    holds: Literal["word", "number", "agent", "agents"]
    words: tuple[str, ...] = ()
    colours: tuple[Colour, ...] = ()
    full: float = 1.0

    def is_drawn(self, word: int) -> bool:
        """Returns whether a shape or a tint shows this word: the first is plain unless it is a colour like all others."""
        return word > 0 or (self.words[0] in WORDS if self.sort == "tint" else set(self.words) <= COLOURS)


@dataclass(frozen=True)
class KindLook:
    """A kind that is on the map: its tile, its fields, and where it is."""

    name: str
    colour: Colour
    solid: bool
    fields: tuple[FieldLook, ...]
    rows: np.ndarray  # [S] int, in reading order
    cols: np.ndarray  # [S] int


@dataclass(frozen=True)
class Look:
    """How a game looks. `tile`: pixels of a cell's side. `colour_field`: the agents' field that colours them, if any.

    roles: the words of that field, if they do not say themselves which colour they are.
    """

    title: str
    height: int
    width: int
    tile: int
    kinds: tuple[KindLook, ...]
    marks: tuple[tuple[str, str, Colour], ...]  # label, attribute of the state, colour
    colour_field: tuple[str, tuple[Colour, ...]] | None
    roles: tuple[str, ...]
    num_agents: int
    can_be_held: bool
    frame: tuple[int, int]
    pad: int

    def agent_colours(self, fields: dict[str, np.ndarray]) -> list[Colour]:
        """Returns the colour of each agent in a state."""
        if self.colour_field is None:
            return [agent_colour(number) for number in range(self.num_agents)]
        attribute, colours = self.colour_field
        return [colours[int(word)] for word in fields[attribute]]


def make_look(env: Environment) -> Look:
    """Returns how the environment's game looks; equal games look equal."""
    game = env.game
    height, width = len(game.rows), len(game.rows[0])
    tile = max(MIN_TILE, min(MAX_WIDTH // width, MAX_HEIGHT // height, MAX_TILE))
    phases = tuple(p for p in (game.start, *game.schedule) if isinstance(p, ir.Phase) and _marks(p))
    colour_field = _colour_field(game)
    marks = zip(phases, mark_colours(tuple(p.label for p in phases)), strict=True)
    return Look(
        title=game.title or game.name,
        height=height,
        width=width,
        tile=tile,
        kinds=tuple(_kinds(game)),
        marks=tuple((phase.label, f"mark_{phase.name}", colour) for phase, colour in marks),
        colour_field=None if colour_field is None else (f"agent_{colour_field.name}", word_colours(colour_field.type.words)),
        roles=() if colour_field is None or set(colour_field.type.words) <= set(WORDS) else colour_field.type.words,
        num_agents=game.agents.number,
        can_be_held=bool(game.agents.forbids),
        frame=env.module.FRAME,
        pad=env.module.PAD,
    )


def _marks(phase: ir.Phase) -> bool:
    return any(isinstance(node, ir.Mark) for node in ir.walk(phase))


def _kinds(game: ir.Game) -> Iterator[KindLook]:
    """Yields the kinds on the map in the order of the file."""
    colours = kind_colours(game)
    kind_of = {meaning.glyph: meaning.kind for meaning in game.glyphs}
    grid = np.array([[kind_of[glyph] for glyph in row] for row in game.rows])
    for kind in game.kinds:
        rows, cols = np.nonzero(grid == kind.name)
        if len(rows):
            solid = any(block.what == "agents" and block.condition is None for block in kind.blocks)
            fields = tuple(_field(f, kind.name, game) for f in kind.fields if f.type.kind != "word" or not f.type.by)
            yield KindLook(kind.name, colours[kind.name], solid, fields, rows, cols)


def _field(field: ir.VarField, kind: str, game: ir.Game) -> FieldLook:
    attribute = f"{kind}_{field.name}"
    match field.type.kind:
        case "word":
            sort = "shape" if _is_written(field.name, kind, game) else "tint"
            return FieldLook(field.name, attribute, sort, "word", field.type.words, word_colours(field.type.words))
        case "agents":
            return FieldLook(field.name, attribute, "bar", "agents", full=game.agents.number)
        case "agent":
            return FieldLook(field.name, attribute, "edge", "agent", colours=tuple(map(agent_colour, range(game.agents.number))))
        case _:
            most = field.type.high if np.isfinite(field.type.high) and not field.timer else TIMER_BAR
            return FieldLook(field.name, attribute, "bar", "number", full=max(1.0, most))


def _is_written(name: str, kind: str, game: ir.Game) -> bool:
    """Returns whether some rule sets the field; one that no rule sets is part of the landscape."""
    targets = (node.target for node in ir.walk(game) if isinstance(node, ir.Set | ir.Add))
    reads = (target.row if isinstance(target, ir.At) else target for target in targets)
    return any(isinstance(read, ir.FieldRead) and read.name == name and kind in read.kinds for read in reads)


def _colour_field(game: ir.Game) -> ir.VarField | None:
    """Returns the field that colours the agents: one whose words all have a colour, else one that no phase changes, a role."""
    fields = [field for field in game.agents.fields if field.type.kind == "word" and not field.type.by]
    coloured = [field for field in fields if all(word in WORDS for word in field.type.words)]
    roles = [field for field in fields if len(field.type.words) > 1 and not _changes(field.name, game)]
    return next(iter(coloured + roles), None)


def _changes(name: str, game: ir.Game) -> bool:
    targets = (node.target for phase in game.schedule for node in ir.walk(phase) if isinstance(node, ir.Set | ir.Add))
    return any(isinstance(target, ir.FieldRead) and (target.place, target.name) == ("agent", name) for target in targets)

"""The appearance of a game: everything about its pictures that does not change from step to step."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Literal, assert_never

import numpy as np

from sjdsl.compiler import ir
from sjdsl.compiler.ir.implications import conjuncts
from sjdsl.compiler.ir.operations import COMPARISONS, REDUCTIONS
from sjdsl.compiler.ir.printer import expression
from sjdsl.compiler.ir.queries import blocks_always, kinds_by_glyph, marking_phases, written_field
from sjdsl.render.colours import COLOURS, SPRITES, WORDS, Colour, agent_colour, kind_colours, mark_colours, read_colour
from sjdsl.render.colours import word_colours as colours_of
from sjdsl.render.usual import Picture, is_passing, is_taken, main_kind, spawn_kinds, usual_body, usual_movers, usual_words

MAX_WIDTH, MAX_HEIGHT = 800, 600  # pixels of the board
MIN_TILE, MAX_TILE = 2, 40
Sort = Literal["shape", "tint", "edge", "bar"]
Values = Mapping[str, np.ndarray]  # attribute of the state -> array


@dataclass(frozen=True)
class FieldLook:
    """A field of a kind, or of the agents, as it is drawn where no `look` reads it.

    sort: a word is a `shape` if rules change it, else a `tint`; an agent is an `edge` of its colour; all that can be counted is a
    `bar`, and `full` fills it.
    holds: `word`, `number`, `agent` (an id, -1 for nobody) or `agents` (bits).
    pictures: of its words; of each entry of a row of numbers; one for a number of the agents.
    """

    name: str
    attribute: str
    sort: Sort
    holds: Literal["word", "number", "agent", "agents"]
    words: tuple[str, ...] = ()
    colours: tuple[Colour, ...] = ()
    pictures: tuple[Picture, ...] = ()
    full: float = 1.0
    start: int = 0

    def is_drawn(self, word: int) -> bool:
        """Returns whether a shape or a tint shows this word: the first is plain unless it is a colour like all others."""
        return word > 0 or (self.words[0] in WORDS if self.sort == "tint" else set(self.words) <= COLOURS)


@dataclass(frozen=True)
class Rule:
    """A `look` of the file. `label`: what its condition says, in short; `reads`: names of fields."""

    condition: ir.Expr | None
    reads: frozenset[str]
    label: str
    sprite: str | None
    colour: Colour | None
    badge: Picture | None

    def applies(self, prefix: str, values: Values, count: int) -> np.ndarray:
        """Returns for which cells or agents it is, `[count]` bool; `prefix`: of the attributes of their fields."""
        if self.condition is None:
            return np.ones(count, bool)
        fields = {name: values[f"{prefix}_{name}"] for name in self.reads}
        return np.broadcast_to(_value(self.condition, fields), (count,)).astype(bool)


@dataclass(frozen=True, eq=False)
class KindLook:
    """A kind that is on the map: its ground, what all its cells show, its fields, its looks, and where it is."""

    name: str
    ground: Colour
    body: Picture | None
    solid: bool
    fields: tuple[FieldLook, ...]
    rules: tuple[Rule, ...]
    rows: np.ndarray  # [S] int, in reading order
    cols: np.ndarray  # [S] int


@dataclass(frozen=True)
class HerdLook:
    """A sort of movers: its body, its looks, and the fields that are drawn as badges."""

    name: str
    glyph: str
    sprite: str
    colour: Colour
    rules: tuple[Rule, ...]
    carried: tuple[FieldLook, ...]


@dataclass(frozen=True)
class Look:
    """How a game looks. `tile`: pixels of a cell's side. `colour_field`: the agents' field that colours them, if any.

    roles: the words of that field, if they do not say themselves which colour they are. carried: fields of the agents that are
    drawn as badges; rules: looks of the agents.
    """

    title: str
    height: int
    width: int
    tile: int
    kinds: tuple[KindLook, ...]
    marks: tuple[tuple[str, Colour], ...]  # label of the phase, colour
    colour_field: tuple[str, tuple[Colour, ...]] | None
    roles: tuple[str, ...]
    carried: tuple[FieldLook, ...]
    rules: tuple[Rule, ...]
    num_agents: int
    can_be_held: bool
    herds: tuple[HerdLook, ...] = ()

    def agent_colours(self, fields: Values) -> list[Colour]:
        """Returns the colour of each agent in a state, where no `look` gives it another."""
        if self.colour_field is None:
            return [agent_colour(number) for number in range(self.num_agents)]
        attribute, colours = self.colour_field
        return [colours[int(word)] for word in fields[attribute]]


def make_look(game: ir.Game) -> Look:
    """Returns how a game looks."""
    height, width = len(game.rows), len(game.rows[0])
    labels = tuple(phase.label for phase in marking_phases(game))
    colour_field = _colour_field(game)
    words = () if colour_field is None else colour_field.type.words
    return Look(
        title=game.title or game.name,
        height=height,
        width=width,
        tile=max(MIN_TILE, min(MAX_WIDTH // width, MAX_HEIGHT // height, MAX_TILE)),
        kinds=tuple(_kind_looks(game)),
        marks=tuple(zip(labels, mark_colours(labels), strict=True)),
        colour_field=None if colour_field is None else (f"agent_{colour_field.name}", colours_of(words)),
        roles=() if set(words) <= set(WORDS) else words,
        carried=tuple(_carried((f for f in game.agents.fields if f is not colour_field), "agent", game)),
        rules=tuple(_rule(look) for look in game.looks if look.what == "agent"),
        num_agents=game.agents.number,
        can_be_held=bool(game.agents.forbids),
        herds=tuple(
            HerdLook(
                name=sort.name,
                glyph=sort.glyph,
                sprite=body.sprite,
                colour=body.colour,
                rules=tuple(_rule(look) for look in game.looks if look.what == "mover" and look.name == sort.name),
                carried=tuple(_carried((f for f in sort.fields if f.name != "heading"), sort.name, game)),
            )
            for sort, body in zip(game.movers, usual_movers(game), strict=True)
        ),
    )


def _kind_looks(game: ir.Game) -> Iterator[KindLook]:
    """Yields the kinds on the map in the order of the file."""
    spawns = spawn_kinds(game)
    grounds = kind_colours(game, spawns, main_kind(game))
    kind_of = kinds_by_glyph(game)
    grid = np.array([[kind_of[glyph] for glyph in row] for row in game.rows])
    for kind in game.kinds:
        rows, cols = np.nonzero(grid == kind.name)
        if len(rows):
            shown = [f for f in kind.fields if not f.timer and (not f.type.by or f.type.kind in ("int", "real"))]
            fields, shapes = [], 0
            for field in shown:
                if not is_passing(field, game):
                    fields.append(_field(field, kind.name, game, shapes))
                    shapes += max(0, len(field.type.words) - 1)
            rules = tuple(_rule(look) for look in game.looks if kind.name in look.kinds)
            ground = grounds[kind.name]
            yield KindLook(kind.name, ground, usual_body(kind, ground, spawns), blocks_always(kind), tuple(fields), rules, rows, cols)


def _rule(look: ir.Look) -> Rule:
    body, badge = look.body or ir.Paint(), look.badge
    shown = None
    if badge is not None:
        sprite = badge.sprite or "disc"
        shown = Picture(sprite, read_colour(badge.colour) if badge.colour else SPRITES[sprite])
    read = () if look.condition is None else [node.name for node in ir.walk(look.condition) if isinstance(node, ir.FieldRead)]
    return Rule(
        condition=look.condition,
        reads=frozenset(read),
        label="" if look.condition is None else _label(look.condition, look.name),
        sprite=body.sprite or None,
        colour=read_colour(body.colour) if body.colour else None,
        badge=shown,
    )


def _label(condition: ir.Expr, name: str) -> str:
    """Returns a condition in short: the words that hold, or what else it says, without the name of the cell."""
    parts = []
    for part in conjuncts(condition):
        match part:
            case ir.Same(right=ir.Word(value=word)) | ir.Same(left=ir.Word(value=word)):
                parts.append(word)
            case ir.InWords():
                parts.append(" or ".join(part.words))
            case ir.Compare(fn=">", left=ir.At(row=ir.FieldRead(name=field), key=ir.Word(value=word)), right=ir.Number(value=0)):
                parts.append(f"{field}: {word}")
            case _:
                text = expression(part).replace(f"{name}.", "")
                parts.append(text[1:-1] if text.startswith("(") and text.endswith(")") else text)
    return ", ".join(parts)


def _field(field: ir.VarField, kind: str, game: ir.Game, shapes: int) -> FieldLook:
    attribute = f"{kind}_{field.name}"
    match field.type.kind:
        case "word":
            sort: Sort = "shape" if _sets(game, ir.Sort("cell", (kind,)), field.name) else "tint"
            pictures = usual_words(field, is_taken(field.name, kind, game), shapes)
            words = field.type.words
            return FieldLook(field.name, attribute, sort, "word", words, colours_of(words), pictures)
        case "agents":
            return FieldLook(field.name, attribute, "bar", "agents", full=game.agents.number)
        case "cell":
            return FieldLook(field.name, attribute, "bar", "number", full=float(1 << 16))
        case "agent":
            return FieldLook(field.name, attribute, "edge", "agent", colours=tuple(map(agent_colour, range(game.agents.number))))
        case _:
            most = field.type.high if np.isfinite(field.type.high) else 10.0
            return FieldLook(field.name, attribute, "bar", "number", full=max(1.0, most))


def _carried(fields: Iterable[ir.VarField], prefix: str, game: ir.Game) -> Iterator[FieldLook]:
    """Yields the fields that an agent or a mover shows in its corners: words and numbers. `prefix`: of their attributes.

    Timers say what it may do, not what it has; rows by agent or by numbers have no words to be pictures of.
    """
    shapes = 0
    for field in fields:
        by, attribute = field.type.by, f"{prefix}_{field.name}"
        if field.timer or any(level.sort != "word" for level in by) or is_passing(field, game):
            continue
        if field.type.kind == "word" and not by:
            pictures = usual_words(field, False, shapes)
            start = field.type.words.index(str(field.start))
            yield FieldLook(field.name, attribute, "shape", "word", field.type.words, pictures=pictures, start=start)
            shapes += len(pictures) - 1
        elif field.type.kind in ("int", "real"):
            words = by[0].names if by else ()
            row = ir.Type(kind="word", words=("nothing", *(words or (field.name,))))
            pictures = usual_words(ir.VarField(name=field.name, held_by=ir.Sort("agent"), type=row), False, shapes)[1:]
            yield FieldLook(field.name, attribute, "shape", "number", words, pictures=pictures)
            shapes += len(pictures)


def _colour_field(game: ir.Game) -> ir.VarField | None:
    """Returns the field that colours the agents: one that no phase changes, whose words are colours if there is such, else a role."""
    fields = [f for f in game.agents.fields if f.type.kind == "word" and not f.type.by and len(f.type.words) > 1]
    lasting = [f for f in fields if not any(_sets(turn, ir.Sort("agent"), f.name) for turn in game.schedule)]
    coloured = [f for f in fields if set(f.type.words) <= COLOURS]
    return next(iter([f for f in coloured if f in lasting] + lasting + coloured), None)


def _sets(rules: ir.Node, owner: ir.Sort, name: str) -> bool:
    """Returns whether some of the rules set a field; one of a kind that no rule sets is part of the landscape."""
    written = (written_field(node.target) for node in ir.walk(rules) if isinstance(node, ir.Set | ir.Add))
    return any(field.name == name and field.held_by.overlaps(owner) for field in written)


def _value(e: ir.Expr, fields: Mapping[str, np.ndarray]) -> Any:
    """Returns an expression of a `look` for each cell or agent: words as texts, agents as numbers with -1 for nobody, sets of agents as bits.

    fields: name of a field -> its values, `[count, ...]`; the compiler lets a `look` read these, words and numbers alone.
    """
    match e:
        case ir.Number() | ir.Word() | ir.Truth():
            return e.value
        case ir.Nobody():
            return -1
        case ir.FieldRead():
            return np.asarray(e.type.words)[fields[e.name]] if e.type.kind == "word" else fields[e.name]
        case ir.At(key=ir.Word(value=key) | ir.Number(value=key)):
            return _value(e.row, fields)[:, e.row.type.by[0].place_of(key)]  # type: ignore[arg-type]
        case ir.SumRow():
            return getattr(np, REDUCTIONS[e.fn].array)(_value(e.row, fields), axis=1)
        case ir.Compare():
            return COMPARISONS[e.fn].holds(_value(e.left, fields), _value(e.right, fields))
        case ir.Same():
            return np.equal(_value(e.left, fields), _value(e.right, fields))
        case ir.InRange():
            value = _value(e.value, fields)
            return (value >= _value(e.low, fields)) & (value <= _value(e.high, fields))
        case ir.InWords():
            return np.isin(_value(e.value, fields), e.words)
        case ir.IsEmpty():
            return _value(e.container, fields) == 0
        case ir.Not():
            return np.logical_not(_value(e.value, fields))
        case ir.Logic():
            join = np.logical_and if e.fn == "and" else np.logical_or
            return join.reduce(np.broadcast_arrays(*(_value(a, fields) for a in e.args)))
        case ir.Named() | ir.Narrowed():
            return _value(e.value, fields)
        case _:
            assert_never(e)  # type: ignore[arg-type]  # the compiler refuses all others in a `look`

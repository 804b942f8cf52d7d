"""The appearance of a game: everything about its pictures that does not change from step to step."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, assert_never

import numpy as np

from sjdsl.compiler import ir
from sjdsl.compiler.ir.implications import conjuncts
from sjdsl.compiler.ir.operations import COMPARISONS, REDUCTIONS
from sjdsl.compiler.ir.queries import (
    blocks_always,
    kinds_by_glyph,
    marking_phases,
    title_of,
    written_field,
)
from sjdsl.render.colours import (
    COLOURS,
    INKS,
    SHAPES,
    SPRITES,
    WORDS,
    Colour,
    agent_colour,
    kind_colours,
    mark_colours,
    read_colour,
    tint_colours,
)
from sjdsl.render.colours import word_colours as colours_of
from sjdsl.render.conditions import in_words
from sjdsl.render.readings import Reading, agent_readings, world_readings
from sjdsl.render.usual import (
    Picture,
    is_taken,
    main_kind,
    named_sprite,
    spawn_kinds,
    usual_body,
    usual_movers,
    usual_words,
)

MAX_WIDTH, MAX_HEIGHT = 800, 600  # pixels of the board
MIN_TILE, MAX_TILE = 2, 40
BADGES = 2  # of an agent: its other corners are in front of its eyes
NOTHING = ("none", "nothing", "empty", "bare")  # words that say that nothing is there
Sort = Literal["shape", "tint", "edge", "bar"]
Values = Mapping[str, np.ndarray]  # attribute of the state -> array


@dataclass(frozen=True)
class FieldLook:
    """A field of a kind, or of the agents, as it is drawn where no `look` reads it.

    sort: a word is a `shape` if rules change it, else a `tint`; an agent is an `edge` of its colour; all that can be counted is a
    `bar`, and `full` fills it.
    holds: `word`, `number`, `agent` (an id, -1 for nobody) or `agents` (bits).
    pictures: of its words, or of each entry of a row of numbers.
    plain: the number of the word that is not drawn. left_out: words that it doesn't draw, because a look does or because agents can't tell them
    apart.
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
    plain: int = 0
    left_out: frozenset[str] = frozenset()

    def is_carried(self, word: int) -> bool:
        """Returns whether an agent or a mover shows this word as a badge: if it is not the one that it starts with."""
        return word != self.start and self.words[word] not in self.left_out

    def is_drawn(self, word: int) -> bool:
        """Returns whether a shape or a tint shows this word: all but the plain one, and that, too, if it is a colour like all others."""
        shown = word != self.plain or (
            self.words[word] in WORDS if self.sort == "tint" else set(self.words) <= COLOURS
        )
        return shown and self.words[word] not in self.left_out


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
    starting: bool = False  # its body is only the mark of a starting place


@dataclass(frozen=True)
class HerdLook:
    """A sort of movers: its body, its looks, and the fields that are drawn as badges."""

    name: str
    sprite: str
    colour: Colour
    rules: tuple[Rule, ...]
    carried: tuple[FieldLook, ...]


@dataclass(frozen=True)
class Look:
    """How a game looks. `tile`: pixels of a cell's side. `colour_field`: the agents' field that colours them, if any.

    marks: label and colour of each phase that marks; acting: its label -> the numbers of the actions with which an agent marks in it.
    roles: the words of the field that colours agents; roles_in_looks: those that a look reads.
    carried: fields of the agents that are drawn as badges; held: their rows of numbers by words, which stand beside an agent's return as
    pictures; world, own: what stands there as text, of the world and of each agent; rules: looks of the agents.
    """

    title: str
    height: int
    width: int
    tile: int
    kinds: tuple[KindLook, ...]
    marks: tuple[tuple[str, Colour], ...]
    acting: Mapping[str, tuple[int, ...]]
    actions: tuple[str, ...]
    colour_field: tuple[str, tuple[Colour, ...]] | None
    roles: tuple[str, ...]
    roles_in_looks: frozenset[str]
    carried: tuple[FieldLook, ...]
    held: tuple[FieldLook, ...]
    world: tuple[Reading, ...]
    own: tuple[Reading, ...]
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
    colour_field, seen = _colour_field(game), seen_fields(game)
    words = () if colour_field is None else colour_field.type.words
    rules = tuple(_rule(look) for look in game.looks if look.what == "agent")
    fields = [
        field
        for field in game.agents.fields
        if field is not colour_field and ("agent", field.name) in seen
    ]
    carried = tuple(_apart(_carried(fields, "agent", rules, game), carried=True))
    held = tuple(_held(fields, game))
    coloured = () if colour_field is None else (colour_field,)
    drawn = {field.name for field in (*coloured, *carried[:BADGES], *held)}
    return Look(
        title=title_of(game),
        height=height,
        width=width,
        tile=max(MIN_TILE, min(MAX_WIDTH // width, MAX_HEIGHT // height, MAX_TILE)),
        kinds=tuple(_kind_looks(game)),
        marks=tuple(zip(labels, mark_colours(labels), strict=True)),
        acting={
            phase.label: tuple(sorted(_marking_actions(phase, game)))
            for phase in marking_phases(game)
        },
        actions=tuple(game.agents.actions),
        colour_field=None
        if colour_field is None
        else (f"agent_{colour_field.name}", colours_of(words)),
        roles=words,
        roles_in_looks=frozenset() if colour_field is None else words_in_looks(colour_field, rules),
        carried=carried,
        held=held,
        world=world_readings(game),
        own=tuple(reading for reading in agent_readings(game) if reading.name not in drawn),
        rules=rules,
        num_agents=game.agents.number,
        can_be_held=bool(game.agents.forbids),
        herds=tuple(
            HerdLook(
                name=sort.name,
                sprite=body.sprite,
                colour=body.colour,
                rules=(
                    own := tuple(
                        _rule(look)
                        for look in game.looks
                        if look.what == "mover" and look.name == sort.name
                    )
                ),
                carried=tuple(_apart(_carried_by(sort, seen, own, game), carried=True)),
            )
            for sort, body in zip(game.movers, usual_movers(game), strict=True)
        ),
    )


def seen_fields(game: ir.Game) -> frozenset[tuple[str, str]]:
    """Returns the fields that agents see, as pairs: a kind, a sort of movers or `agent`, and the field's name.

    Fields of cells that decide which label is seen are among them. All others are the rules' own bookkeeping, and aren't drawn.
    """
    found: set[tuple[str, str]] = set()
    for observable in game.observables:
        if observable.what in ("cell", "mover"):
            read = (
                node
                for label in observable.labels
                for node in ir.walk(label)
                if isinstance(node, ir.FieldRead)
            )
            found |= {
                (observable.kind, observable.field),
                *((kind, node.name) for node in read for kind in _kinds_of(node.owner)),
            }
        elif observable.what in ("own", "other", "everyone"):
            found.add(("agent", observable.field))
    return frozenset(found)


def merged_words(kind: str, field: ir.VarField, game: ir.Game) -> frozenset[str]:
    """Returns the words of a field of cells that agents can't tell apart: they see only labels, and no label reads these words."""
    seen = [
        observable
        for observable in game.observables
        if observable.what == "cell" and observable.kind == kind
    ]
    if field.type.kind != "word" or any(
        observable.field == field.name and not observable.labels for observable in seen
    ):
        return frozenset()
    conditions = [
        label.condition
        for observable in seen
        for label in observable.labels
        if label.condition is not None
    ]
    nodes = [node for condition in conditions for node in ir.walk(condition)]
    asking = [node for node in nodes if isinstance(node, ir.Same | ir.InWords) and _words(node)]
    reads, worded = (
        sum(isinstance(n, ir.FieldRead) and n.name == field.name for n in some)
        for some in (nodes, map(_compared_value, asking))
    )
    rest = {*field.type.words} - {word for node in asking for word in _words(node)}
    return frozenset(rest) if len(rest) > 1 and reads == worded else frozenset()


def _compared_value(node: ir.Expr) -> ir.Expr:
    """Returns the side of a comparison with words that isn't a word."""
    if isinstance(node, ir.Same):
        return node.right if isinstance(node.left, ir.Word) else node.left
    return node.value if isinstance(node, ir.InWords) else node


def _kinds_of(owner: ir.Expr | None) -> tuple[str, ...]:
    """Returns the kinds of the cell whose field is read; none if it is a field of an agent or a mover."""
    return owner.sort.names if isinstance(owner, ir.Member) and owner.sort.what == "cell" else ()


def _marking_actions(
    node: ir.Node, game: ir.Game, chosen: frozenset[int] = frozenset()
) -> Iterator[int]:
    """Yields the numbers of the actions with which agents mark in a part of the rules. chosen: those that the conditions around it require."""
    if isinstance(node, ir.Mark):
        yield from chosen
    parts = [part for part in ir.children(node) if not isinstance(part, ir.Statement | ir.Branch)]
    for read in (inner for part in parts for inner in ir.walk(part)):
        if isinstance(read, ir.Chose):
            chosen |= {read.action}
        elif isinstance(read, ir.ChoseWith):
            chosen |= {
                number
                for number, name in enumerate(game.agents.actions)
                if name.split("(")[0] == read.action
            }
    for part in ir.children(node):
        if isinstance(part, ir.Statement | ir.Branch):
            yield from _marking_actions(part, game, chosen)


def _kind_looks(game: ir.Game) -> Iterator[KindLook]:
    """Yields the kinds on the map in the order of the file."""
    spawns, seen = spawn_kinds(game), seen_fields(game)
    grounds = kind_colours(game, spawns, main_kind(game))
    kind_of = kinds_by_glyph(game)
    grid = np.array([[kind_of[glyph] for glyph in row] for row in game.rows])
    for kind in game.kinds:
        rows, cols = np.nonzero(grid == kind.name)
        if len(rows):
            rules = tuple(_rule(look) for look in game.looks if kind.name in look.kinds)
            fields: list[FieldLook] = []
            shapes = 0
            for field in kind.fields:
                is_row = bool(field.type.by) and field.type.kind not in ("int", "real")
                is_read = field.type.kind != "word" and any(
                    field.name in rule.reads for rule in rules
                )
                if (kind.name, field.name) in seen and not (field.timer or is_row or is_read):
                    tinted = any(other.sort == "tint" for other in fields)
                    left_out = words_in_looks(field, rules) | merged_words(kind.name, field, game)
                    fields.append(_field(field, kind.name, game, shapes, tinted, left_out))
                    shapes += max(0, len(field.type.words) - 1)
            fields = list(_apart(fields))
            ground, starting = grounds[kind.name], kind.name in spawns
            body = usual_body(kind, ground, spawns)
            yield KindLook(
                kind.name,
                ground,
                body,
                blocks_always(kind),
                tuple(fields),
                rules,
                rows,
                cols,
                starting,
            )


def _rule(look: ir.Look) -> Rule:
    body, badge = look.body or ir.Paint(), look.badge
    shown = None
    if badge is not None:
        sprite = badge.sprite or "disc"
        shown = Picture(sprite, read_colour(badge.colour) if badge.colour else SPRITES[sprite])
    read = (
        ()
        if look.condition is None
        else [node.name for node in ir.walk(look.condition) if isinstance(node, ir.FieldRead)]
    )
    return Rule(
        condition=look.condition,
        reads=frozenset(read),
        label="" if look.condition is None else in_words(look.condition),
        sprite=body.sprite or None,
        colour=read_colour(body.colour) if body.colour else None,
        badge=shown,
    )


def words_in_looks(field: ir.VarField, rules: tuple[Rule, ...]) -> frozenset[str]:
    """Returns the words of a field that some look reads."""
    parts = [
        part
        for rule in rules
        if rule.condition is not None and field.name in rule.reads
        for part in conjuncts(rule.condition)
    ]
    return frozenset(
        word for part in parts if not isinstance(part, ir.Not) for word in _words(part)
    ) & {*field.type.words}


def _words(part: ir.Expr) -> frozenset[str]:
    """Returns the words with which a condition holds, or the entries of a row that it reads."""
    match part:
        case ir.InWords():
            return frozenset(part.words)
        case ir.Same():
            return frozenset(
                side.value for side in (part.left, part.right) if isinstance(side, ir.Word)
            )
        case _:
            return frozenset(node.value for node in ir.walk(part) if isinstance(node, ir.Word))


def _field(
    field: ir.VarField,
    kind: str,
    game: ir.Game,
    shapes: int,
    tinted: bool,
    left_out: frozenset[str],
) -> FieldLook:
    """Returns how a field of cells is drawn. `tinted`: the ground shows another field already; two colours in one would be a third."""
    attribute = f"{kind}_{field.name}"
    match field.type.kind:
        case "word":
            few_colours = len({*tint_colours(field.type.words)[1:]}) < len(field.type.words) - 1
            is_shape = tinted or few_colours or _sets(game, ir.Sort("cell", (kind,)), field.name)
            sort: Sort = "shape" if is_shape else "tint"
            pictures = usual_words(field, is_taken(field.name, kind, game), shapes)
            words = field.type.words
            colours = tint_colours(words) if sort == "tint" else colours_of(words)
            plain = next((number for number, word in enumerate(words) if word in NOTHING), 0)
            return FieldLook(
                field.name,
                attribute,
                sort,
                "word",
                words,
                colours,
                pictures,
                plain=plain,
                left_out=left_out,
            )
        case "agents":
            return FieldLook(field.name, attribute, "bar", "agents", full=game.agents.number)
        case "cell":
            return FieldLook(field.name, attribute, "bar", "number", full=float(1 << 16))
        case "agent":
            return FieldLook(
                field.name,
                attribute,
                "edge",
                "agent",
                colours=tuple(map(agent_colour, range(game.agents.number))),
            )
        case _:
            most = field.type.high if np.isfinite(field.type.high) else 10.0
            return FieldLook(field.name, attribute, "bar", "number", full=max(1.0, most))


def _apart(fields: Iterable[FieldLook], carried: bool = False) -> Iterator[FieldLook]:
    """Yields the fields of one kind, of the agents or of a sort of movers; no two pictures that are drawn are alike.

    Args:
      carried: they are drawn as badges.
    """
    used: set[Picture] = set()
    for field in fields:
        if field.sort != "shape" or field.holds != "word":
            yield field
            continue
        pictures = list(field.pictures)
        for word in filter(field.is_carried if carried else field.is_drawn, range(len(pictures))):
            picture = pictures[word]
            if picture in used:
                others = (
                    Picture(sprite, colour)
                    for colour in (picture.colour, *INKS)
                    for sprite in SHAPES
                )
                pictures[word] = next((other for other in others if other not in used), picture)
            used.add(pictures[word])
        yield replace(field, pictures=tuple(pictures))


def _carried(
    fields: Sequence[ir.VarField], prefix: str, rules: tuple[Rule, ...], game: ir.Game
) -> Iterator[FieldLook]:
    """Yields the words that an agent or a mover shows as badges. `prefix`: of their attributes."""
    shapes = 0
    for field in fields:
        if field.type.kind == "word" and not field.type.by:
            words, attribute = field.type.words, f"{prefix}_{field.name}"
            pictures = _as_looked(words, usual_words(field, False, shapes), game)
            start, asked = words.index(str(field.start)), words_in_looks(field, rules)
            yield FieldLook(
                field.name,
                attribute,
                "shape",
                "word",
                words,
                pictures=pictures,
                start=start,
                left_out=asked,
            )
            shapes += len(pictures) - 1


def _carried_by(
    sort: ir.Movers, seen: frozenset[tuple[str, str]], rules: tuple[Rule, ...], game: ir.Game
) -> Iterator[FieldLook]:
    """Yields the words that a mover shows as badges; its heading is seen by the way it looks."""
    fields = [
        field
        for field in sort.fields
        if field.name != "heading" and (sort.name, field.name) in seen
    ]
    yield from _carried(fields, sort.name, rules, game)


def _held(fields: Sequence[ir.VarField], game: ir.Game) -> Iterator[FieldLook]:
    """Yields what the agents have of each of several words."""
    for field in fields:
        if field.type.kind in ("int", "real") and [level.sort for level in field.type.by] == [
            "word"
        ]:
            words = field.type.by[0].names
            row = ir.Type(kind="word", words=("nothing", *words))
            usual = usual_words(
                ir.VarField(name=field.name, held_by=ir.Sort("agent"), type=row), False
            )[1:]
            yield FieldLook(
                field.name,
                f"agent_{field.name}",
                "shape",
                "number",
                words,
                pictures=_as_looked(words, usual, game),
            )


def _as_looked(
    words: Sequence[str], usual: Sequence[Picture], game: ir.Game
) -> tuple[Picture, ...]:
    """Returns for each word the sprite that a look shows where it asks for the word, so that what is carried looks as what lies about.

    Other words, and those that are named after a sprite, keep their usual one.
    """
    found = dict(zip(words, usual, strict=True))
    for rule in map(_rule, game.looks):
        shown = rule.badge or (
            Picture(rule.sprite, rule.colour or SPRITES[rule.sprite]) if rule.sprite else None
        )
        if shown is not None and rule.condition is not None:
            asked = [
                word
                for part in map(_words, conjuncts(rule.condition))
                if len(part) == 1
                for word in part
            ]
            found |= {word: shown for word in asked if word in found and named_sprite(word) is None}
    return tuple(found[word] for word in words)


def _colour_field(game: ir.Game) -> ir.VarField | None:
    """Returns the field that colours the agents: one that no phase changes, whose words are colours if there is such, else a role."""
    fields = [
        f
        for f in game.agents.fields
        if f.type.kind == "word" and not f.type.by and len(f.type.words) > 1
    ]
    fields = [
        f for f in fields if len({*colours_of(f.type.words)}) == len(f.type.words)
    ]  # or roles would look alike
    lasting = [
        f
        for f in fields
        if not any(_sets(turn, ir.Sort("agent"), f.name) for turn in game.schedule)
    ]
    coloured = [f for f in fields if set(f.type.words) <= COLOURS]
    return next(iter([f for f in coloured if f in lasting] + lasting + coloured), None)


def _sets(rules: ir.Node, owner: ir.Sort, name: str) -> bool:
    """Returns whether some of the rules set a field; one of a kind that no rule sets is part of the landscape."""
    written = (
        written_field(node.target) for node in ir.walk(rules) if isinstance(node, ir.Set | ir.Add)
    )
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
            return (
                np.asarray(e.type.words)[fields[e.name]]
                if e.type.kind == "word"
                else fields[e.name]
            )
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

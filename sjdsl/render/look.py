"""The appearance of a game: all about its pictures that doesn't change from step to step."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from sjdsl.compiler import ir
from sjdsl.compiler.ir.fold import fold
from sjdsl.compiler.ir.implications import conjuncts
from sjdsl.compiler.ir.names import attribute_name
from sjdsl.compiler.ir.queries import (
    kinds_by_glyph,
    marking_phases,
    title_of,
    written_field,
)
from sjdsl.compiler.ir.values import Evaluation
from sjdsl.interpreter.stored import loaded
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

MAX_WIDTH = 800  # pixels of the board
MAX_HEIGHT = 600
MIN_TILE = 2
MAX_TILE = 40
BADGES = 2  # of an agent: its other corners are in front of its eyes
NOTHING = ("none", "nothing", "empty", "bare")  # enum values: nothing is there
DrawnAs = Literal["shape", "tint", "edge", "bar"]
Values = Mapping[str, np.ndarray]  # attribute of the state -> array


@dataclass(frozen=True)
class FieldLook:
    """A field of a kind, of agents or of movers, as it is drawn where no `look` reads it.

    drawn_as: an enum value is a `shape` if rules change it, else a `tint`; an agent is an `edge` in
    its colour; all that can be counted is a `bar`, and `full` fills it.
    holds: `word` (an enum value), `number`, `agent` (an id, -1 for nobody) or `agents` (bits).
    words: its enum values, or those that index a field of numbers; pictures: one for each.
    colours: one for each enum value of a tint, or for each agent of an edge.
    start: the number of the enum value that it starts with; plain: of the one that isn't drawn.
    left_out: enum values that it doesn't draw, because a look does or because agents can't tell
    them apart.
    """

    name: str
    attribute: str
    drawn_as: DrawnAs
    holds: Literal["word", "number", "agent", "agents"]
    words: tuple[str, ...] = ()
    colours: tuple[Colour, ...] = ()
    pictures: tuple[Picture, ...] = ()
    full: float = 1.0
    start: int = 0
    plain: int = 0
    left_out: frozenset[str] = frozenset()

    def is_carried(self, word: int) -> bool:
        """Returns whether a badge shows an enum value: not the one that the field starts with."""
        return word != self.start and self.words[word] not in self.left_out

    def is_drawn(self, word: int) -> bool:
        """Returns whether a shape or a tint shows an enum value.

        All but the plain one are shown, and that, too, if it is a colour like all others.
        """
        if self.words[word] in self.left_out:
            return False
        if word != self.plain:
            return True
        if self.drawn_as == "tint":
            return self.words[word] in WORDS
        return set(self.words) <= COLOURS


@dataclass(frozen=True)
class Rule:
    """A `look` of the file. label: its condition in short; reads: names of the fields in it."""

    condition: ir.Expr | None
    reads: frozenset[str]
    label: str
    sprite: str | None
    colour: Colour | None
    badge: Picture | None

    @property
    def picture(self) -> Picture | None:
        """The sprite that it draws, in its colour or the usual one."""
        if self.sprite is None:
            return None
        return Picture(self.sprite, self.colour or SPRITES[self.sprite])

    def applies(self, prefix: str, values: Values, count: int) -> np.ndarray:
        """Returns to which of `count` cells, agents or movers it applies, `[count]` bool.

        Args:
          prefix: what the names of their attributes in `values` begin with, such as `agent`.
        """
        columns = {name: values[f"{prefix}_{name}"].tolist() for name in sorted(self.reads)}
        results: dict[str, bool] = {}  # the fields' values as text -> whether it applies
        applies: list[bool] = []
        for number in range(count):
            fields = {name: column[number] for name, column in columns.items()}
            key = str(fields)
            if key not in results:
                results[key] = self._holds(fields)
            applies.append(results[key])
        return np.array(applies, bool)

    def _holds(self, fields: Mapping[str, Any]) -> bool:
        """Returns whether the condition holds. `fields`: the values, as the state stores them."""

        def read(e: ir.Expr) -> Any:
            assert isinstance(e, ir.FieldRead), e  # the compiler refuses all others in a `look`
            return loaded(fields[e.name], e.type)

        return self.condition is None or bool(fold(self.condition, Evaluation(read)))


@dataclass(frozen=True, eq=False)
class KindLook:
    """A kind that is on the map, and where its cells are. body: what all of them show."""

    name: str
    ground: Colour
    body: Picture | None
    fields: tuple[FieldLook, ...]
    rules: tuple[Rule, ...]
    rows: np.ndarray  # [S] int, in reading order
    cols: np.ndarray  # [S] int
    starting: bool = False  # its body is only the mark of a starting place


@dataclass(frozen=True)
class HerdLook:
    """A type of mover: its body, its looks, and the fields that are drawn as badges."""

    name: str
    sprite: str
    colour: Colour
    rules: tuple[Rule, ...]
    carried: tuple[FieldLook, ...]


@dataclass(frozen=True)
class Look:
    """How a game looks. tile: pixels of a cell's side.

    marks: label and colour of each phase that marks; marking_actions: its label -> the numbers of
    the actions with which an agent marks in it.
    colour_field: attribute and colours of the field that colours agents, if one does; roles: its
    enum values; roles_in_looks: those that a look reads.
    carried: fields of the agents that are drawn as badges; possessions: their indexed fields of
    numbers, drawn as pictures beside their returns; world, own: what stands below the board as
    text, of the world and of each agent; rules: looks of the agents.
    """

    title: str
    height: int
    width: int
    tile: int
    kinds: tuple[KindLook, ...]
    marks: tuple[tuple[str, Colour], ...]
    marking_actions: Mapping[str, tuple[int, ...]]
    actions: tuple[str, ...]
    colour_field: tuple[str, tuple[Colour, ...]] | None
    roles: tuple[str, ...]
    roles_in_looks: frozenset[str]
    carried: tuple[FieldLook, ...]
    possessions: tuple[FieldLook, ...]
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
    height = len(game.rows)
    width = len(game.rows[0])
    marking = marking_phases(game)
    labels = tuple(phase.label for phase in marking)
    rules = tuple(_make_rule(look) for look in game.looks if look.what == "agent")
    fields = _seen_fields_of("agent", game.agents.fields, game)
    role_field = _colour_field(game)
    colour_field = None
    roles: tuple[str, ...] = ()
    roles_in_looks: frozenset[str] = frozenset()
    drawn: set[str] = set()
    if role_field is not None:
        roles = role_field.type.words
        colour_field = (attribute_name(role_field), colours_of(roles))
        roles_in_looks = words_in_looks(role_field, rules)
        fields = [field for field in fields if field is not role_field]
        drawn.add(role_field.name)
    carried = tuple(_carried_fields("agent", fields, rules, game))
    possessions = tuple(_possessions(fields, game))
    drawn |= {field.name for field in (*carried[:BADGES], *possessions)}
    marking_actions = {}
    for phase in marking:
        marking_actions[phase.label] = tuple(sorted(_marking_actions(phase, game)))
    return Look(
        title=title_of(game),
        height=height,
        width=width,
        tile=max(MIN_TILE, min(MAX_WIDTH // width, MAX_HEIGHT // height, MAX_TILE)),
        kinds=tuple(_kind_looks(game)),
        marks=tuple(zip(labels, mark_colours(labels), strict=True)),
        marking_actions=marking_actions,
        actions=game.agents.actions,
        colour_field=colour_field,
        roles=roles,
        roles_in_looks=roles_in_looks,
        carried=carried,
        possessions=possessions,
        world=world_readings(game),
        own=tuple(reading for reading in agent_readings(game) if reading.name not in drawn),
        rules=rules,
        num_agents=game.agents.number,
        can_be_held=bool(game.agents.forbids),
        herds=tuple(_herd_looks(game)),
    )


def _herd_looks(game: ir.Game) -> Iterator[HerdLook]:
    """Yields the types of mover in the order of the file."""
    for mover, body in zip(game.movers, usual_movers(game), strict=True):
        looks = [look for look in game.looks if (look.what, look.name) == ("mover", mover.name)]
        rules = tuple(map(_make_rule, looks))
        seen = _seen_fields_of(mover.name, mover.fields, game)
        fields = [field for field in seen if field.name != "heading"]  # its body faces there
        carried = tuple(_carried_fields(mover.name, fields, rules, game))
        yield HerdLook(mover.name, body.sprite, body.colour, rules, carried)


def _seen_fields_of(owner: str, fields: Iterable[ir.VarField], game: ir.Game) -> list[ir.VarField]:
    """Returns the fields of a kind, of a type of mover or of `agent` that agents see."""
    seen = seen_fields(game)
    return [field for field in fields if (owner, field.name) in seen]


def seen_fields(game: ir.Game) -> frozenset[tuple[str, str]]:
    """Returns the fields that agents see: (kind, type of mover or `agent`, name of the field).

    Fields of cells that decide which label is seen are among them. All others are the rules' own
    bookkeeping, and aren't drawn.
    """
    seen: set[tuple[str, str]] = set()
    for observable in game.observables:
        if observable.what in ("cell", "mover"):
            seen.add((observable.kind, observable.field))
            for label in observable.labels:
                seen |= _cell_fields_in(label)
        elif observable.what in ("own", "other", "everyone"):
            seen.add(("agent", observable.field))
    return frozenset(seen)


def _cell_fields_in(label: ir.Node) -> set[tuple[str, str]]:
    """Returns kind and name of the fields of cells that the condition of a label reads."""
    fields: set[tuple[str, str]] = set()
    for node in ir.walk(label):
        if isinstance(node, ir.FieldRead) and isinstance(node.owner, ir.Member):
            if node.owner.entity_type.what == "cell":
                fields |= {(kind, node.name) for kind in node.owner.entity_type.names}
    return fields


def merged_words(kind: str, field: ir.VarField, game: ir.Game) -> frozenset[str]:
    """Returns the enum values of a field of cells that agents can't tell apart.

    Agents see only labels instead of the field, and the labels' conditions, such as
    `fruit is ripe`, compare it with other values than these.
    """
    if field.type.kind != "word":
        return frozenset()
    nodes: list[ir.Node] = []
    for observable in game.observables:
        if observable.what == "cell" and observable.kind == kind:
            if observable.field == field.name and not observable.labels:
                return frozenset()  # agents see its value
            for label in observable.labels:
                nodes += ir.walk(label)
    num_reads = 0
    num_compared = 0  # reads that are compared with enum values
    unmentioned = {*field.type.words}
    for node in nodes:
        num_reads += _is_read_of(field, node)
        if isinstance(node, ir.Same | ir.InWords):
            words = _words(node)
            unmentioned -= words
            num_compared += bool(words) and _is_read_of(field, _compared_value(node))
    # A read that is compared with something else may tell all values apart.
    if num_reads != num_compared or len(unmentioned) == 1:
        return frozenset()
    return frozenset(unmentioned)


def _is_read_of(field: ir.VarField, node: ir.Node) -> bool:
    return isinstance(node, ir.FieldRead) and node.name == field.name


def _compared_value(node: ir.Same | ir.InWords) -> ir.Expr:
    """Returns the side of a comparison with enum values that isn't one itself."""
    if isinstance(node, ir.InWords):
        return node.value
    return node.right if isinstance(node.left, ir.Word) else node.left


def _marking_actions(
    node: ir.Node, game: ir.Game, chosen: frozenset[int] = frozenset()
) -> Iterator[int]:
    """Yields the numbers of the actions with which agents mark in a part of the rules.

    In `each agent as a where a chose zap { mark beam of a }` it is that of `zap`.

    Args:
      chosen: the actions that conditions around this part ask for.
    """
    if isinstance(node, ir.Mark):
        yield from chosen
    inner_rules: list[ir.Node] = []
    for part in ir.children(node):
        if isinstance(part, ir.Statement | ir.Branch):
            inner_rules.append(part)
            continue
        for read in ir.walk(part):
            if isinstance(read, ir.Chose):
                chosen |= {read.action}
            elif isinstance(read, ir.ChoseWith):
                chosen |= {
                    number
                    for number, name in enumerate(game.agents.actions)
                    if name.split("(")[0] == read.action
                }
    for part in inner_rules:
        yield from _marking_actions(part, game, chosen)


def _kind_looks(game: ir.Game) -> Iterator[KindLook]:
    """Yields the kinds on the map in the order of the file."""
    spawns = spawn_kinds(game)
    grounds = kind_colours(game, spawns, main_kind(game))
    kind_of = kinds_by_glyph(game)
    grid = np.array([[kind_of[glyph] for glyph in row] for row in game.rows])
    for kind in game.kinds:
        rows, cols = np.nonzero(grid == kind.name)
        if len(rows):
            ground = grounds[kind.name]
            looks = tuple(_make_rule(look) for look in game.looks if kind.name in look.kinds)
            yield KindLook(
                name=kind.name,
                ground=ground,
                body=usual_body(kind, ground, spawns),
                fields=tuple(_tell_apart(_cell_fields(kind, looks, game), FieldLook.is_drawn)),
                rules=looks,
                rows=rows,
                cols=cols,
                starting=kind.name in spawns,
            )


def _cell_fields(kind: ir.Kind, rules: tuple[Rule, ...], game: ir.Game) -> list[FieldLook]:
    """Returns the fields of a kind that are drawn where no `look` reads them."""
    looks: list[FieldLook] = []
    shapes = 0
    for field in _seen_fields_of(kind.name, kind.fields, game):
        is_indexed = bool(field.type.indexed_by) and field.type.kind not in ("int", "real")
        is_read = field.type.kind != "word" and any(field.name in rule.reads for rule in rules)
        if field.timer or is_indexed or is_read:
            continue
        tinted = any(look.drawn_as == "tint" for look in looks)
        left_out = words_in_looks(field, rules) | merged_words(kind.name, field, game)
        looks.append(_make_field_look(field, kind.name, game, shapes, tinted, left_out))
        shapes += max(0, len(field.type.words) - 1)
    return looks


def _make_rule(look: ir.Look) -> Rule:
    """Returns a `look` of the file with its colours and names of fields resolved."""
    body = look.body or ir.Paint()
    badge: Picture | None = None
    if look.badge is not None:
        sprite = look.badge.sprite or "disc"
        colour = read_colour(look.badge.colour) if look.badge.colour else SPRITES[sprite]
        badge = Picture(sprite, colour)
    reads: frozenset[str] = frozenset()
    label = ""
    if look.condition is not None:
        nodes = ir.walk(look.condition)
        reads = frozenset(node.name for node in nodes if isinstance(node, ir.FieldRead))
        label = in_words(look.condition)
    return Rule(
        condition=look.condition,
        reads=reads,
        label=label,
        sprite=body.sprite or None,
        colour=read_colour(body.colour) if body.colour else None,
        badge=badge,
    )


def words_in_looks(field: ir.VarField, rules: tuple[Rule, ...]) -> frozenset[str]:
    """Returns the enum values of a field that some look asks for."""
    words: set[str] = set()
    for rule in rules:
        if rule.condition is not None and field.name in rule.reads:
            for part in conjuncts(rule.condition):
                if not isinstance(part, ir.Not):
                    words |= _words(part)
    return frozenset(words & {*field.type.words})


def _words(part: ir.Expr) -> frozenset[str]:
    """Returns the enum values that a condition mentions: compared values, and keys of rows."""
    match part:
        case ir.InWords():
            return frozenset(part.words)
        case ir.Same():
            return frozenset(
                side.value for side in (part.left, part.right) if isinstance(side, ir.Word)
            )
        case _:
            return frozenset(node.value for node in ir.walk(part) if isinstance(node, ir.Word))


def _make_field_look(
    field: ir.VarField,
    kind: str,
    game: ir.Game,
    shapes: int,
    tinted: bool,
    left_out: frozenset[str],
) -> FieldLook:
    """Returns how a field of cells is drawn.

    Args:
      shapes: how many shapes other fields of the kind have taken.
      tinted: whether another field tints the ground; two tints would mix to a third colour.
    """
    attribute = attribute_name(field)
    match field.type.kind:
        case "word":
            words = field.type.words
            tints = tint_colours(words)
            has_few_tints = len({*tints[1:]}) < len(words) - 1
            is_set = _is_set(game, ir.EntityType("cell", (kind,)), field.name)
            is_shape = tinted or has_few_tints or is_set
            return FieldLook(
                field.name,
                attribute,
                "shape" if is_shape else "tint",
                "word",
                words,
                colours=colours_of(words) if is_shape else tints,
                pictures=usual_words(field, is_taken(field.name, kind, game), shapes),
                plain=next((number for number, word in enumerate(words) if word in NOTHING), 0),
                left_out=left_out,
            )
        case "agents":
            return FieldLook(field.name, attribute, "bar", "agents", full=game.agents.number)
        case "cell":
            return FieldLook(field.name, attribute, "bar", "number", full=float(1 << 16))
        case "agent":
            colours = tuple(map(agent_colour, range(game.agents.number)))
            return FieldLook(field.name, attribute, "edge", "agent", colours=colours)
        case _:
            most = field.type.high if np.isfinite(field.type.high) else 10.0
            return FieldLook(field.name, attribute, "bar", "number", full=max(1.0, most))


def _tell_apart(
    fields: Iterable[FieldLook], is_visible: Callable[[FieldLook, int], bool]
) -> Iterator[FieldLook]:
    """Yields the fields of one owner; where two pictures would be the same, the second is another.

    Args:
      is_visible: (a field, the number of an enum value) -> whether the value is drawn.
    """
    used: set[Picture] = set()
    for field in fields:
        if field.drawn_as != "shape" or field.holds != "word":
            yield field
            continue
        pictures = list(field.pictures)
        for word, picture in enumerate(field.pictures):
            if not is_visible(field, word):
                continue
            if picture in used:
                inks = (picture.colour, *INKS)
                others = (Picture(shape, ink) for ink in inks for shape in SHAPES)
                pictures[word] = next((other for other in others if other not in used), picture)
            used.add(pictures[word])
        yield replace(field, pictures=tuple(pictures))


def _carried_fields(
    owner: str, fields: Sequence[ir.VarField], rules: tuple[Rule, ...], game: ir.Game
) -> Iterator[FieldLook]:
    """Yields the fields whose enum values agents, or a type of mover, show as badges."""
    carried: list[FieldLook] = []
    shapes = 0
    for field in fields:
        if field.type.kind == "word" and not field.type.indexed_by:
            words = field.type.words
            pictures = _as_in_looks(words, usual_words(field, False, shapes), game)
            carried.append(
                FieldLook(
                    field.name,
                    f"{owner}_{field.name}",
                    "shape",
                    "word",
                    words,
                    pictures=pictures,
                    start=words.index(str(field.start)),
                    left_out=words_in_looks(field, rules),
                )
            )
            shapes += len(pictures) - 1
    return _tell_apart(carried, FieldLook.is_carried)


def _possessions(fields: Sequence[ir.VarField], game: ir.Game) -> Iterator[FieldLook]:
    """Yields the fields that count what an agent has of each of several enum values."""
    for field in fields:
        kinds = [index_set.kind for index_set in field.type.indexed_by]
        if field.type.kind in ("int", "real") and kinds == ["word"]:
            words = field.type.indexed_by[0].names
            as_words = ir.Type(kind="word", words=("nothing", *words))
            things = ir.VarField(name=field.name, held_by=ir.EntityType("agent"), type=as_words)
            _, *pictures = usual_words(things, False)
            yield FieldLook(
                field.name,
                attribute_name(field),
                "shape",
                "number",
                words,
                pictures=_as_in_looks(words, pictures, game),
            )


def _as_in_looks(
    words: Sequence[str], usual: Sequence[Picture], game: ir.Game
) -> tuple[Picture, ...]:
    """Returns a picture for each enum value: that of the look whose condition asks for the value.

    So what is carried looks like what lies about. Other enum values, and those that are named
    after a sprite, keep their usual picture.

    Args:
      usual: the usual picture of each of `words`.
    """
    pictures = dict(zip(words, usual, strict=True))
    for rule in map(_make_rule, game.looks):
        picture = rule.badge or rule.picture
        if picture is None or rule.condition is None:
            continue
        for part in conjuncts(rule.condition):
            part_words = _words(part)
            for word in part_words:
                if len(part_words) == 1 and word in pictures and named_sprite(word) is None:
                    pictures[word] = picture
    return tuple(pictures[word] for word in words)


def _colour_field(game: ir.Game) -> ir.VarField | None:
    """Returns the field whose enum values colour the agents, None without one.

    The first of: one of colours that no phase changes; another that no phase changes; one of
    colours.
    """
    fields = []
    for field in game.agents.fields:
        words = field.type.words
        is_word = field.type.kind == "word" and not field.type.indexed_by and len(words) > 1
        if is_word and len({*colours_of(words)}) == len(words):  # else roles would look alike
            fields.append(field)
    agent = ir.EntityType("agent")
    lasting = []
    for field in fields:
        if not any(_is_set(turn, agent, field.name) for turn in game.schedule):
            lasting.append(field)
    coloured = [field for field in fields if set(field.type.words) <= COLOURS]
    lasting_coloured = [field for field in coloured if field in lasting]
    best_first = (*lasting_coloured, *lasting, *coloured)
    return next(iter(best_first), None)


def _is_set(rules: ir.Node, owner: ir.EntityType, name: str) -> bool:
    """Returns whether some of the rules set a field.

    A field of a kind that no rule sets is part of the landscape.
    """
    for node in ir.walk(rules):
        if isinstance(node, ir.Set | ir.Add):
            field = written_field(node.target)
            if field.name == name and field.held_by.overlaps(owner):
                return True
    return False

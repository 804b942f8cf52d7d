"""Random declarations: numbers, kinds with fields of every type, a map, shapes, agents, events."""

from random import Random

from sjdsl.compiler import ir
from sjdsl.compiler.ir.entity_types import IndexSet
from sjdsl.compiler.ir.types import UNIT_LIMITS
from tests.fuzz.acting import declare_actions
from tests.fuzz.declared import Event, Field, Kind, Number, Shape, World

WORDS = ("none", "ripe", "red", "blue", "low", "high", "glad")
KINDS = ("grass", "tree", "pond", "rock", "gate")
FIELDS = ("fruit", "depth", "age", "owner", "fans", "stock", "worth", "left")
AGENT_FIELDS = ("bag", "mood", "purse", "last", "met", "debt", "tired", "rank")
WORLD_FIELDS = ("pot", "turns", "king", "night", "sky")
SIZES = ("reach", "most", "wide", "span", "team")
PARAMS = (
    "pay",
    "fee",
    "luck",
    "rain",
    "share",
    "delay",
    "few",
    "many",
    "table_a",
    "table_b",
    "swap",
)
MOVERS = ("deer", "ball", "cart")
ACTIONS = ("zap", "peer", "hand_over")
MOVES = ("turn_left", "turn_right", "step_left", "step_right", "forward", "backward")
EVENTS = ("seen", "eaten", "hits", "deals")
GLYPHS = "gtpkeaxyzwvu"
CROWDS = 0.01  # how often there are more agents than one number of 32 bits holds


def declare(random: Random) -> World:
    """Returns a world with everything but rules."""
    w = World(random)
    w.agents = (
        random.choice((1, 2, 2, 3, 3, 4, 5)) if not w.is_now(CROWDS) else random.choice((33, 36))
    )
    for _ in range(random.randint(2, 3)):
        w.word_sets.append(tuple(random.sample(WORDS, random.randint(2, 4))))
    for name in random.sample(SIZES, random.randint(1, 3)):
        w.sizes.append(size(w, name))
    for i, name in enumerate(random.sample(KINDS, random.randint(2, 4))):
        fields = [
            a_field(w, f, sets=True)
            for f in random.sample(FIELDS, random.choice((0, 1, 1, 2, 2, 3)))
        ]
        w.kinds[name] = Kind(name, ".#TOGD"[i], fields, glyphs=[".#TOGD"[i]])
    names = list(w.kinds)
    if w.is_now(0.6):
        w.groups["ground"] = tuple(random.sample(names, random.randint(1, min(3, len(names)))))
    _alike(w)
    for name in random.sample(AGENT_FIELDS, random.randint(1, 4)):
        w.agent_fields.append(a_field(w, name, sets=True))
    for name in random.sample(WORLD_FIELDS, random.choice((0, 1, 1, 2))):
        w.fields.append(a_field(w, name, sets=True))
    w.word_sets = [s for s in w.word_sets if s in _declared_sets(w)] or [_some_words(w)]
    for name in random.sample(PARAMS, random.randint(2, 6)):
        w.params.append(param(w, name))
    acts = [
        *random.sample(MOVES, random.randint(2, 6)),
        "stay",
        *random.sample(ACTIONS, random.randint(1, 3)),
    ]
    random.shuffle(acts)
    w.actions = tuple(acts) if random.random() < 0.97 else ("stay",)
    for i, name in enumerate(random.sample(MOVERS, random.choice((0, 0, 1, 1, 2)))):
        fields = [a_field(w, f, sets=True) for f in random.sample(FIELDS, random.choice((0, 1, 2)))]
        w.movers[name] = Kind(name, "do"[i], fields, cells=random.choice((1, 1, 2, 3)))
    shapes(w)
    for name in random.sample(EVENTS, random.randint(1, 3)):
        w.events.append(Event(name, w.level() if w.is_now(0.4) else None, w.is_now(0.5)))
    _glyphs(w)
    _map(w)
    w.with_arguments = declare_actions(w)
    return w


def _declared_sets(w: World) -> list[tuple[str, ...]]:
    fields = [
        *w.agent_fields,
        *w.fields,
        *(f for k in (*w.kinds.values(), *w.movers.values()) for f in k.fields),
    ]
    levels = (
        (f.type.words, *(level.names for level in f.type.indexed_by if level.kind == "word"))
        for f in fields
    )
    return list(dict.fromkeys(s for own in levels for s in own if s))


def _some_words(w: World) -> tuple[str, ...]:
    """A game without a field of words gets one."""
    made = a_field(w, "colour", sets=False, sort="word")
    w.agent_fields.append(made)
    return made.type.words


def _alike(w: World) -> None:
    """The kinds of a group often share a field."""
    for kinds in w.groups.values():
        given = w.kinds[kinds[0]].fields
        if given and w.is_now(0.8):
            for other in kinds[1:]:
                mine = {f.name for f in w.kinds[other].fields}
                w.kinds[other].fields += [f for f in given if f.name not in mine]


def size(w: World, name: str) -> Number:
    """Returns a size of a few, perhaps computed from one before."""
    r = w.random
    unit = r.choice(("count", "steps", "cells"))
    value = r.randint(1, 3)
    written = str(value)
    before = [s for s in w.sizes if s.type.unit == unit]
    if before and w.is_now(0.5):
        other = r.choice(before)
        written, value = r.choice(
            (
                (f"{other.name} + 1", other.value + 1),
                (f"min({other.name}, 2)", min(other.value, 2)),
                (f"max({other.name} * 2 - 1, 1)", max(other.value * 2 - 1, 1)),
                (f"{other.name} % 4 + 1", other.value % 4 + 1),
                (f"({other.name} + {other.name}) / 2", other.value),
            )
        )
    limits = f" in 0 .. {value + 3}" if w.is_now(0.4) else ""
    type_ = ir.Type(kind="int", unit=unit, low=value, high=value)
    return Number(name, type_, f"size  {name} : {unit} = {written}{limits}", value)


def param(w: World, name: str) -> Number:
    """Returns a param of any unit, with or without limits, single or a table."""
    r = w.random
    unit = r.choice(
        (
            "count",
            "steps",
            "cells",
            "reward",
            "reward",
            "probability",
            "probability",
            "fraction",
            "number",
            "word",
        )
    )
    levels = r.choice((0, 0, 0, 1, 1, 2))
    if unit == "word":
        made = _words_param(w, name, bool(levels))
        if made is not None:
            return made
        unit = "reward"
    by = tuple(
        w.level() if not i and w.is_now(0.4) else IndexSet("word", r.choice(w.word_sets))
        for i in range(levels)
    )
    said = f" by {by[0]}" if by and (by[0].kind != "word" or w.is_now(0.2)) else ""
    whole = unit in ("count", "steps", "cells")
    low, high = UNIT_LIMITS[unit]
    limits = ""
    if w.is_now(0.5):
        low, high = (
            (0, r.randint(2, 5))
            if whole
            else (r.choice((0, -2)), r.choice((2, 3.5)))
            if unit in ("reward", "number")
            else (0.0, r.choice((0.5, 0.3, 1)))
        )
        if whole and w.is_now(0.3):
            low = 1
        limits = f" in {low} .. {high}"

    def value() -> str:
        if whole:
            return str(r.randint(int(low), 4 if high > 4 else int(high)))
        if unit in ("reward", "number"):
            return r.choice(
                ("1", "2", "0.5", "0", "0.25", "1.75") + (("-1", "-0.5") if low < 0 else ())
            )
        return r.choice(
            ("0", "0.25", "0.3", "0.125") if high < 1 else ("0.5", "0.7", "0.1", "1", "0")
        )

    type_ = ir.Type(kind="int" if whole else "real", unit=unit, low=low, high=high, indexed_by=by)
    return Number(
        name, type_, f"param {name}{said} : {unit} = {_table(w, by, value, bool(said))}{limits}"
    )


def _words_param(w: World, name: str, table: bool) -> Number | None:
    """Returns a param whose values are words, if these are together in one set of words only: then that is its type."""
    r = w.random
    by = (IndexSet("word", r.choice(w.word_sets)),) if table else ()
    words = r.choice(w.word_sets)
    given: list[str] = []

    def value() -> str:
        given.append(r.choice(words))
        return given[-1]

    text = f"param {name} : word = {_table(w, by, value)}"
    if any(
        set(given) <= set(s) for s in (*(level.names for level in by), *w.word_sets) if s != words
    ):
        return None
    return Number(name, ir.Type(kind="word", words=words, indexed_by=by), text)


def _table(w: World, by: tuple[IndexSet, ...], value, said: bool = False) -> str:
    """Returns a table, or, where what it is by is said, perhaps one value for all, or some and `otherwise`."""
    if not by:
        return value()
    if said and w.is_now(0.3) and (len(by) == 1 or by[0].kind != "word"):
        return _table(w, by[1:], value)
    if said and (by[0].kind == "agent" or (len(by[0]) > 1 and w.is_now(0.5))):
        known = [name for name in by[0].keys if not name.startswith("-")]
        keys = w.random.sample(known, w.random.randint(0, len(known) - 1))
        first, last = by[0].names[0], by[0].names[-1]
        if by[0].kind == "number" and w.is_now(0.3) and int(last) > 0:
            keys = [w.random.choice((f"{last} ..", f"{max(int(first), 0)} .. {last}"))]
            keys = [] if keys[0].startswith(f"{first} .. ") else keys
        return (
            "{ "
            + ", ".join(f"{k}: {_table(w, by[1:], value)}" for k in [*keys, "otherwise"])
            + " }"
        )
    if by[0].kind == "number" and by[0].first < 0:
        return _table(w, by[1:], value)
    keys = list(by[0].keys)
    w.random.shuffle(keys)
    return "{ " + ", ".join(f"{k}: {_table(w, by[1:], value)}" for k in keys) + " }"


def a_field(w: World, name: str, sets: bool, sort: str = "") -> Field:
    """Returns a field of any type; `sets`: also a set of agents."""
    r = w.random
    sorts = (
        "word",
        "word",
        "word",
        "int",
        "int",
        "int",
        "capped",
        "capped",
        "agent",
        "real",
        "timer",
    ) + (("agents",) if sets else ())
    sorts += ("cell",) if w.kinds else ()
    sort = sort or r.choice(sorts)
    by = (
        (w.level(),)
        if sort != "timer" and w.is_now(0.4 if sort in ("int", "capped") else 0.06)
        else ()
    )
    rows = f" by {by[0]}" if by else ""
    match sort:
        case "timer":
            by = (w.level(),) if w.is_now(0.2) else ()
            rows = f" by {by[0]}" if by else ""
            type_ = ir.Type(kind="int", unit="steps", low=0, indexed_by=by)
            return Field(name, type_, f"timer {name}{rows}", timer=True)
        case "word":
            words = r.choice(w.word_sets)
            text = f"field {name}{rows} : {{ {', '.join(words)} }} = {r.choice(words)}"
            return Field(name, ir.Type(kind="word", words=words, indexed_by=by), text)
        case "agent":
            return Field(
                name,
                ir.Type(kind="agent", indexed_by=by),
                f"field {name}{rows} : agent{' = nobody' if w.is_now(0.3) else ''}",
            )
        case "cell":
            of = r.choice([*w.kinds, *w.groups])
            type_ = ir.Type(kind="cell", kinds=w.kinds_of(of), indexed_by=by)
            return Field(
                name,
                type_,
                f"field {name}{rows} : cell of {of}{' = nowhere' if w.is_now(0.3) else ''}",
            )
        case "agents":
            return Field(
                name, ir.Type(kind="agents", indexed_by=by), f"field {name}{rows} : set of agent"
            )
        case "real" if w.is_now(0.4):
            is_capped = w.is_now(0.7)
            range_ = "number in -4 .. 4 capped" if is_capped else "number in -4 .. 4"
            return Field(
                name,
                ir.Type(kind="real", unit="number", low=-4, high=4, indexed_by=by),
                f"field {name}{rows} : {range_} = {r.choice((0.5, -1, 0.1))}",
                capped=is_capped,
            )
        case "real":
            start = r.choice(("", "", " = 1.5", " = -0.25"))
            return Field(
                name,
                ir.Type(kind="real", unit="reward", indexed_by=by),
                f"field {name}{rows} : reward{start}",
            )
    low, high, written, unit = r.choice((0, 0, 0, 1, -2)), r.randint(2, 9), "", "count"
    written = str(high)
    if w.is_now(0.3):
        bound = r.choice(w.sizes)
        low, high, written, unit = 0, bound.value, bound.name, bound.type.unit
    elif w.is_now(0.1):
        high, written = 300, "300"
    capped = " capped" if sort == "capped" else ""
    type_ = ir.Type(kind="int", unit=unit, low=low, high=high, indexed_by=by)
    return Field(
        name,
        type_,
        f"field {name}{rows} : {low} .. {written}{capped} = {r.randint(low, min(high, 9))}",
        capped=bool(capped),
    )


def shapes(w: World) -> None:
    """Declares shapes with names; those that are used unnamed are made when they are used."""
    r = w.random
    for name in r.sample(("ray", "beam", "cone", "patch", "ring"), r.randint(1, 3)):
        if w.is_now(0.4):
            rows = [
                [r.choice("x..") for _ in range(r.choice((1, 3, 3)))]
                for _ in range(r.randint(1, 3))
            ]
            width = len(rows[0])
            rows = [row[:width] + ["."] * (width - len(row)) for row in rows]
            anchor = r.randrange(len(rows)), r.randrange(width)
            rows[anchor[0]][anchor[1]] = "^"
            if not any("x" in row for row in rows):
                rows.insert(0, ["x"] * width)
            picture = " ".join('"' + "".join(row) + '"' for row in rows)
            w.shape_texts.append(f"shape {name} {{ {picture} }}")
            w.shapes.append(Shape(name, True, sum(row.count("x") for row in rows), True))
        else:
            made = form(w)
            w.shape_texts.append(f"shape {name} = {made.text}")
            w.shapes.append(Shape(name, made.directed, made.size, made.directed))


def form(w: World, directed: bool = True) -> Shape:
    """Returns one of the five forms, small."""
    r = w.random
    name = r.choice(
        ("line", "fan", "disc", "diamond", "square") if directed else ("disc", "diamond", "square")
    )
    number = (
        r.choice([s for s in w.sizes if 1 <= s.value <= 3]).name
        if w.is_now(0.2) and any(1 <= s.value <= 3 for s in w.sizes)
        else ""
    )
    n = r.randint(1, 3) if name == "line" else r.randint(1, 2)
    value = next((s.value for s in w.sizes if s.name == number), n)
    written = number or str(n)
    match name:
        case "line":
            return Shape(f"line({written})", True, value)
        case "fan":
            return Shape(f"fan({written}, 1)", True, value * 3)
        case _:
            centre = ", centre" if w.is_now(0.4) else ""
            return Shape(f"{name}({written}{centre})", False, (2 * value + 1) ** 2)


def _glyphs(w: World) -> None:
    free = iter(GLYPHS)
    for kind in w.kinds.values():
        plain = [
            f
            for f in kind.fields
            if f.type.kind in ("word", "int", "real") and not f.type.indexed_by and not f.timer
        ]
        if plain and w.is_now(0.5):
            glyph = next(free)
            given = []
            for f in w.random.sample(plain, w.random.randint(1, len(plain))):
                if f.type.kind == "word":
                    value = w.random.choice(f.type.words)
                else:
                    value = (
                        str(w.random.randint(int(f.type.low), min(int(f.type.high), 9)))
                        if f.type.kind == "int"
                        else "2.5"
                    )
                given.append(f"with {f.name} = {value}")
            kind.extra.append(f'glyph "{glyph}" {" ".join(given)}')
            kind.glyphs.append(glyph)


def _map(w: World) -> None:
    """Draws a map with enough cells of the first kind for everybody."""
    r = w.random
    height, width = (r.randint(3, 5), r.randint(3, 7)) if w.bodies < 20 else (6, 8)
    kinds = list(w.kinds.values())
    common = kinds[0]
    absent = kinds[-1] if len(kinds) > 2 and w.is_now(0.15) else None
    legend = [(k, g) for k in kinds if k is not absent for g in k.glyphs]
    grid = [
        [r.choice(legend) if w.is_now(0.6) else (common, common.glyph) for _ in range(width)]
        for _ in range(height)
    ]
    cells = [(i, j) for i in range(height) for j in range(width)]
    for i, j in r.sample(cells, min(len(cells), w.bodies + 1)):
        grid[i][j] = (common, common.glyph)
    for row in grid:
        for kind, _ in row:
            kind.cells += 1
    w.rows = ["".join(g for _, g in row) for row in grid]

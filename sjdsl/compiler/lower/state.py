"""Lowers the state: dtype, shape and starting value of each field, the classes State, Params and Outcome, and what an environment knows of them."""

from math import isfinite

from sjdsl.compiler import ir
from sjdsl.compiler.ir.names import attribute_name, attribute_of, param_attribute
from sjdsl.compiler.ir.queries import (
    all_fields,
    body_sorts,
    counts_of,
    marking_phases,
    written_field,
)
from sjdsl.compiler.ir.sorts import Level
from sjdsl.compiler.lower import state_reads
from sjdsl.compiler.lower.expressions import nobody
from sjdsl.compiler.lower.statements import mark_size
from sjdsl.compiler.lower.writer import Writer
from sjdsl.compiler.program import Field
from sjdsl.compiler.program import expressions as array
from sjdsl.runtime.fields import StateField

STORED = {"u8": "uint8", "u32": "uint32", "i32": "int32", "f32": "float32", "bool": "bool_"}
INT32 = array.path("jnp.int32")


def state_fields(game: ir.Game, w: Writer) -> list[Field]:
    """Returns the attributes of State."""

    found = [
        Field(
            "step",
            "[]",
            "int32",
            "finished steps of this episode",
            array.call("jnp.int32", array.Literal(0)),
        )
    ]
    for sort in body_sorts(game):
        found += _pose_fields(sort, w)
    found += [_field(field, game, w) for field in all_fields(game)]
    for phase in marking_phases(game):
        size = mark_size(phase, game)
        zeros = array.call(
            "jnp.zeros",
            w.module.number(f"marks_of_{phase.name}", size, f"cells that {phase.label} can mark"),
            INT32,
        )
        found.append(
            Field(
                f"mark_{phase.name}",
                f"[{size}]",
                "int32",
                f"cells marked by {phase.label}; 0: none",
                zeros,
            )
        )
    return found


def _pose_fields(sort: ir.Sort, w: Writer) -> list[Field]:
    """Returns where agents, or the movers of a sort, are; the heading of a mover is a field of its own."""
    extent, is_agent = w.module.extent(sort), sort.what == "agent"

    def of_each(name: str, comment: str, dtype: str = "int32") -> Field:
        zeros = array.call("jnp.zeros", extent, INT32 if dtype == "int32" else array.Name("bool"))
        return Field(
            attribute_of(name, sort),
            "[N]" if is_agent else f"[{extent.size}]",
            dtype,
            comment,
            zeros,
        )

    found = [of_each("position", f"cell of each {sort.name} in the padded frame; 0: nowhere")]
    if is_agent:
        found.append(of_each("heading", "0 north, 1 east, 2 south, 3 west"))
    if w.module.stores_moved(sort):
        found.append(of_each("moved", "did the last movement change the cell", "bool_"))
    if w.module.stores_away(sort):
        who = (
            f"ticks until {'an' if is_agent else 'a'} {sort.name} that is nowhere returns; 0: never"
        )
        found.append(of_each("away", who))
        found.append(of_each("away_pool", "where it was sent"))
        found.append(of_each("away_facing", "heading it will have; 4: any, 5: the same"))
    return found


def _field(field: ir.VarField, game: ir.Game, w: Writer) -> Field:
    dtype = STORED[state_reads.storage(field, w)]
    extent = None if field.held_by.what == "world" else w.module.extent(field.held_by)
    dims = {"cell": "S", "agent": "N"}.get(field.held_by.what) or (
        "" if extent is None else str(extent.size)
    )
    words = (
        (array.Literal(w.module.set_words),)
        if field.type.kind == "agents" and w.module.set_words
        else ()
    )
    shape = ", ".join(
        ([dims] if dims else [])
        + [str(len(by)) for by in field.type.by]
        + [str(number.size) for number in words]
    )
    layout = w.module.layout
    kind = field.held_by.name
    starts = layout.starts(kind, field) if field.held_by.what == "cell" else {field.start}
    if len(starts) <= 1:
        size = (
            *([] if extent is None else [extent]),
            *map(w.module.num_entries, field.type.by),
            *words,
        )
        first = _start(next(iter(starts), field.start), field, w)
        default: array.Expression = array.call(
            "jnp.full", array.shape_of(size), first, array.path(f"jnp.{dtype}")
        )
    else:
        given = {s for g in game.glyphs if g.kind == kind for n, s in g.starts if n == field.name}
        encode = {s: _start(s, field, w).value for s in given | starts | {field.start}}
        table = layout.starts_table(kind, field, encode, dtype)  # type: ignore[arg-type]
        default = w.module.constant(
            f"{attribute_name(field)}_start", table, f"{field.name} of {kind} as on the map"
        )
        if field.type.by:
            columns = array.Index(default, (array.ALL, array.NEW_AXIS))
            default = array.call(
                "jnp.repeat", columns, w.module.num_entries(field.type.by[0]), axis=array.Literal(1)
            )
    meaning = f"{field.name}: {_meaning(field)}" + (
        f"; by {_level(field.type.by[0])}" if field.type.by else ""
    )
    return Field(attribute_name(field), f"[{shape}]", dtype, meaning, default)


def _level(level: Level) -> str:
    """Returns what the entries of a row are, for a comment."""
    return ", ".join(level.names) if level.sort == "word" else str(level)


def _meaning(field: ir.VarField) -> str:
    match field.type.kind:
        case "word":
            return ", ".join(f"{i} {w}" for i, w in enumerate(field.type.words))
        case "agents":
            return "agents as bits"
        case "agent":
            return "an agent's id, -1 nobody"
        case "cell":
            return f"a cell of {', '.join(field.type.kinds)}, 256 * row + column, -1 nowhere"
        case _ if field.timer:
            return "steps left"
        case _ if field.type.unit == "reward":
            return "a reward"
        case _:
            return f"{field.type.low:g} .. {field.type.high:g}"


def _start(value: object, field: ir.VarField, w: Writer) -> array.Literal:
    """Returns a starting value as the field keeps it."""
    match field.type.kind:
        case "word":
            node = w.module.word(value, field.type.words, field).node  # type: ignore[arg-type]
        case "agent":
            node = nobody(w).node
        case "cell":
            node = state_reads.no_cell(w).node
        case "agents":
            node = array.Literal(0)
        case _:
            node = array.Literal(value)  # type: ignore[arg-type]
    assert isinstance(node, array.Literal)
    return node


def params_fields(game: ir.Game) -> list[Field]:
    """Returns the attributes of Params."""
    found = []
    for param in game.params:
        dtype = {"int": "int32", "real": "float32", "word": "uint8"}[param.type.kind]
        shape = "[" + ", ".join(str(len(by)) for by in param.type.by) + "]"
        by = "".join(f" by {level}" for level in param.type.by)
        unit = "word" if param.type.kind == "word" else param.type.unit
        default = array.call(
            "jnp.asarray",
            array.constant(param_value(param.value, param.type)),
            array.path(f"jnp.{dtype}"),
        )
        found.append(Field(param_attribute(param.name), shape, dtype, f"{unit}{by}", default))
    return found


def param_value(value: object, type_: ir.Type) -> object:
    """Returns a parameter's value as nested lists of numbers; words as their numbers."""
    if isinstance(value, tuple):
        return [param_value(v, type_) for v in value]
    return type_.words.index(value) if type_.kind == "word" else value


def outcome_fields(game: ir.Game, w: Writer) -> list[Field]:
    """Returns the attributes of Outcome."""
    found = [
        Field(
            "reward",
            "[N]",
            "float32",
            "raw rewards of this step",
            array.call("jnp.zeros", w.module.agents, array.DTYPES["f32"]),
        ),
        Field(
            "ended",
            "[]",
            "bool_",
            "whether an `end` was performed",
            array.call("jnp.zeros", array.Sequence(()), array.Name("bool")),
        ),
    ]
    for event in game.events:
        size = (
            *([w.module.agents] if event.per_agent else []),
            *([w.module.num_entries(event.by)] if event.by else []),
        )
        shape = ", ".join(
            (["N"] if event.per_agent else []) + ([str(len(event.by))] if event.by else [])
        )
        comment = "counts of this step" + (f", by {_level(event.by)}" if event.by else "")
        zeros = array.call("jnp.zeros", array.shape_of(size), INT32)
        found.append(
            Field(f"event_{param_attribute(event.name)}", f"[{shape}]", "int32", comment, zeros)
        )
    return found


ROLE = "role"  # a field of the agents by this name says who plays what


def events(game: ir.Game) -> tuple[tuple[str, str, int | None], ...]:
    """Returns each count of a step: its name, the attribute of the outcome, and which entry of its last axis."""
    return tuple(
        (name, f"event_{param_attribute(event.name)}", None if word is None else i)
        for event in game.events
        for i, (word, name) in enumerate(counts_of(event))
    )


def described_fields(game: ir.Game) -> tuple[StateField, ...]:
    """Returns every declared variable: those of cells, of agents, of movers, each sort after where its members are, and of the world."""
    found: list[StateField] = []
    for field in all_fields(game):
        attribute, type_ = attribute_name(field), field.type
        if (field.held_by.what, field.name) == ("mover", "heading"):
            found.append(StateField(attribute_of("position", field.held_by), "place"))
        match type_.kind:
            case "word":
                found.append(StateField(attribute, "word", size=len(type_.words)))
            case "agent" | "agents" | "cell" | "condition":
                found.append(StateField(attribute, type_.kind))
            case _:
                limited = isfinite(type_.low) and isfinite(type_.high) and type_.low < type_.high
                low, high = (type_.low, type_.high) if limited else (None, None)
                found.append(StateField(attribute, "number", low=low, high=high))
    return tuple(found)


def role_attribute(game: ir.Game) -> str | None:
    """Returns the attribute of State that holds the agents' roles; None if they have none, or a phase of the schedule writes it."""
    field = next(
        (
            f
            for f in game.agents.fields
            if f.name == ROLE and f.type.kind == "word" and not f.type.by
        ),
        None,
    )
    written = [
        written_field(node.target)
        for turn in game.schedule
        for node in ir.walk(turn)
        if isinstance(node, ir.Set)
    ]
    if field is None or any((read.held_by.what, read.name) == ("agent", ROLE) for read in written):
        return None
    return attribute_name(field)

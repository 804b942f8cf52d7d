"""Lowers the state: the attributes of State, Params and Outcome, and what describes them."""

from math import isfinite

from sjdsl.compiler import ir
from sjdsl.compiler.ir.entity_types import IndexSet
from sjdsl.compiler.ir.names import attribute_name, attribute_of, param_attribute
from sjdsl.compiler.ir.queries import (
    all_fields,
    body_types,
    counts_of,
    marking_phases,
    written_field,
)
from sjdsl.compiler.lower import state_reads
from sjdsl.compiler.lower.expressions import nobody
from sjdsl.compiler.lower.statements import mark_size
from sjdsl.compiler.lower.writer import Writer
from sjdsl.compiler.program import Field
from sjdsl.compiler.program.expressions import (
    Expression,
    Literal,
    call,
    constant,
    path,
    shape_of,
    zeros,
)
from sjdsl.runtime.fields import StateField

STORED = {"u8": "uint8", "u32": "uint32", "i32": "int32", "f32": "float32", "bool": "bool_"}
INT32 = path("jnp.int32")


def state_fields(game: ir.Game, w: Writer) -> list[Field]:
    """Returns the attributes of State."""
    zero = call("jnp.int32", 0)
    fields = [Field("step", "[]", "int32", "finished steps of this episode", zero)]
    for entity_type in body_types(game):
        fields += _pose_fields(entity_type, w)
    fields += [_field(field, game, w) for field in all_fields(game)]
    for phase in marking_phases(game):
        size = mark_size(phase, game)
        comment = f"cells that {phase.label} can mark"
        number = w.module.number(f"marks_of_{phase.name}", size, comment)
        none = zeros("i32", number)
        meaning = f"cells marked by {phase.label}; 0: none"
        fields.append(Field(f"mark_{phase.name}", f"[{size}]", "int32", meaning, none))
    return fields


def _pose_fields(entity_type: ir.EntityType, w: Writer) -> list[Field]:
    """Returns where agents, or the movers of a name, are and look.

    The heading of a mover is a field of the game.
    """
    extent = w.module.extent(entity_type)
    is_agent = entity_type.what == "agent"
    shape = "[N]" if is_agent else f"[{extent.size}]"

    def of_each(name: str, meaning: str) -> Field:
        none = zeros("i32", extent)
        return Field(attribute_of(name, entity_type), shape, "int32", meaning, none)

    fields = [
        of_each("position", f"cell of each {entity_type.name} in the padded frame; 0: nowhere")
    ]
    if is_agent:
        fields.append(of_each("heading", "0 north, 1 east, 2 south, 3 west"))
    if w.module.stores_moved(entity_type):
        no = zeros("bool", extent)
        meaning = "did the last movement change the cell"
        fields.append(Field(attribute_of("moved", entity_type), shape, "bool_", meaning, no))
    if w.module.stores_away(entity_type):
        one = f"an {entity_type.name}" if is_agent else f"a {entity_type.name}"
        fields.append(of_each("away", f"ticks until {one} that is nowhere returns; 0: never"))
        fields.append(of_each("away_pool", "where it was sent"))
        fields.append(of_each("away_facing", "heading it will have; 4: any, 5: the same"))
    return fields


def _field(field: ir.VarField, game: ir.Game, w: Writer) -> Field:
    """Returns the attribute that keeps a field of the game."""
    dtype = STORED[state_reads.storage(field, w)]
    dims: list[str] = []
    if field.held_by.what != "world":
        extent = w.module.extent(field.held_by)
        dims.append({"cell": "S", "agent": "N"}.get(field.held_by.what, str(extent.size)))
    dims += [str(len(index_set)) for index_set in field.type.indexed_by]
    meaning = f"{field.name}: {_meaning(field)}"
    if field.type.indexed_by:
        meaning = f"{meaning}; by {_index_set_text(field.type.indexed_by[0])}"
    dims += [str(extent.size) for extent in w.module.set_extents(field.type)]
    default = _default(field, game, dtype, w)
    return Field(attribute_name(field), f"[{', '.join(dims)}]", dtype, meaning, default)


def _index_set_text(index_set: IndexSet) -> str:
    """Returns what the entries of a row are, for a comment."""
    return ", ".join(index_set.names) if index_set.kind == "word" else str(index_set)


def _meaning(field: ir.VarField) -> str:
    """Returns what the numbers of a field mean, for the comment beside it."""
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


def _start(value: object, field: ir.VarField, w: Writer) -> Literal:
    """Returns a starting value as the field keeps it."""
    match field.type.kind:
        case "word":
            node = w.module.word(value, field.type.words, field).node  # type: ignore[arg-type]
        case "agent":
            node = nobody(w).node
        case "cell":
            node = state_reads.no_cell(w).node
        case "agents":
            node = Literal(0)
        case _:
            node = Literal(value)  # type: ignore[arg-type]
    assert isinstance(node, Literal)
    return node


def _default(field: ir.VarField, game: ir.Game, dtype: str, w: Writer) -> Expression:
    """Returns the starting values of a field."""
    layout = w.layout
    kind = field.held_by.name
    starts: set[object] = {field.start}
    if field.held_by.what == "cell":
        starts = layout.starts(kind, field)
    if len(starts) <= 1:
        size: list[Expression] = []
        if field.held_by.what != "world":
            size.append(w.module.extent(field.held_by))
        size += map(w.module.num_entries, field.type.indexed_by)
        size += w.module.set_extents(field.type)
        [start] = starts or {field.start}
        first = _start(start, field, w)
        return call("jnp.full", shape_of(tuple(size)), first, path(f"jnp.{dtype}"))
    for glyph in game.glyphs:
        if glyph.kind == kind:
            starts |= {value for name, value in glyph.starts if name == field.name}
    encode = {start: _start(start, field, w).value for start in starts | {field.start}}
    table = layout.starts_table(kind, field, encode, dtype)  # type: ignore[arg-type]
    comment = f"{field.name} of {kind} as on the map"
    vector = w.module.constant(f"{attribute_name(field)}_start", table, comment)
    if not field.type.indexed_by:
        return vector
    column = vector[:, None]
    num_entries = w.module.num_entries(field.type.indexed_by[0])
    return call("jnp.repeat", column, num_entries, axis=1)


def params_fields(game: ir.Game) -> list[Field]:
    """Returns the attributes of Params."""
    fields = []
    for param in game.params:
        kind = param.type.kind
        index_sets = param.type.indexed_by
        dtype = {"int": "int32", "real": "float32", "word": "uint8"}[kind]
        shape = ", ".join(str(len(index_set)) for index_set in index_sets)
        unit = kind if kind == "word" else param.type.unit
        meaning = " by ".join(map(str, (unit, *index_sets)))
        value = constant(param_value(param.value, param.type))
        default = call("jnp.asarray", value, path(f"jnp.{dtype}"))
        fields.append(Field(param_attribute(param.name), f"[{shape}]", dtype, meaning, default))
    return fields


def param_value(value: object, type_: ir.Type) -> object:
    """Returns a parameter's value as nested lists of numbers; words as their numbers."""
    if isinstance(value, tuple):
        return [param_value(v, type_) for v in value]
    return type_.words.index(value) if type_.kind == "word" else value


def outcome_fields(game: ir.Game, w: Writer) -> list[Field]:
    """Returns the attributes of Outcome."""
    no_reward = zeros("f32", w.module.agents)
    not_ended = zeros("bool")
    fields = [
        Field("reward", "[N]", "float32", "raw rewards of this step", no_reward),
        Field("ended", "[]", "bool_", "whether an `end` was performed", not_ended),
    ]
    for event in game.events:
        size: list[Expression] = []
        dims: list[str] = []
        meaning = "counts of this step"
        if event.per_agent:
            size.append(w.module.agents)
            dims.append("N")
        if event.by is not None:
            size.append(w.module.num_entries(event.by))
            dims.append(str(len(event.by)))
            meaning = f"{meaning}, by {_index_set_text(event.by)}"
        none = zeros("i32", *size)
        name = f"event_{param_attribute(event.name)}"
        fields.append(Field(name, f"[{', '.join(dims)}]", "int32", meaning, none))
    return fields


ROLE = "role"  # a field of the agents by this name says who plays what


def events(game: ir.Game) -> tuple[tuple[str, str, int | None], ...]:
    """Returns each count of a step: name, attribute of Outcome, and entry of its last axis."""
    counts = []
    for event in game.events:
        attribute = f"event_{param_attribute(event.name)}"
        for entry, (word, name) in enumerate(counts_of(event)):
            counts.append((name, attribute, None if word is None else entry))
    return tuple(counts)


def described_fields(game: ir.Game) -> tuple[StateField, ...]:
    """Returns every variable of the game: of cells, agents, movers and the world.

    Of movers, the cells on which they are come before their first field, `heading`.
    """
    described: list[StateField] = []
    for field in all_fields(game):
        attribute = attribute_name(field)
        type_ = field.type
        is_first_of_movers = field.held_by.what == "mover" and field.name == "heading"
        if is_first_of_movers:
            described.append(StateField(attribute_of("position", field.held_by), "place"))
        match type_.kind:
            case "word":
                described.append(StateField(attribute, "word", size=len(type_.words)))
            case "agent" | "agents" | "cell" | "condition":
                described.append(StateField(attribute, type_.kind))
            case _ if isfinite(type_.low) and isfinite(type_.high) and type_.low < type_.high:
                described.append(StateField(attribute, "number", low=type_.low, high=type_.high))
            case _:
                described.append(StateField(attribute, "number"))
    return tuple(described)


def role_attribute(game: ir.Game) -> str | None:
    """Returns the attribute of State that holds the agents' roles.

    None if they have none, or a phase of the schedule writes it.
    """
    for turn in game.schedule:
        for node in ir.walk(turn):
            if isinstance(node, ir.Set):
                written = written_field(node.target)
                if written.held_by.what == "agent" and written.name == ROLE:
                    return None
    for field in game.agents.fields:
        if field.name == ROLE and field.type.kind == "word" and not field.type.indexed_by:
            return attribute_name(field)
    return None

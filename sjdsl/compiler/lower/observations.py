"""Lowers `observe`: paints the map once, cuts it into windows, and decodes observation planes.

The map is painted as bytes, the same for all observers (`painting.py`). Each observer's window is
cut out of it. The parts of its bytes then become the planes that the observer is shown: what is
hidden from it is taken out, and other agents are turned as it sees them.
"""

from dataclasses import replace
from math import prod

from sjdsl.compiler import ir
from sjdsl.compiler.ir.entity_types import AGENTS
from sjdsl.compiler.ir.queries import seen_heading, shown_field, shows_attribute, view_size
from sjdsl.compiler.lower import state_reads
from sjdsl.compiler.lower.axes import (
    TRUE,
    Axes,
    Value,
    as_dtype,
    called,
    iota,
    literal,
    select,
    spread,
    taken,
)
from sjdsl.compiler.lower.cell_appearance import (
    COVERED,
    OTHER_FACING,
    Look,
    agent_labels,
    content_labels,
    looks,
    relative_heading,
    shown_words,
)
from sjdsl.compiler.lower.expressions import agent as agent_of
from sjdsl.compiler.lower.expressions import first_of
from sjdsl.compiler.lower.painting import (
    Part,
    first_look,
    look_number,
    paint_planes,
    parts_of,
    shift_of,
)
from sjdsl.compiler.lower.scope import (
    AgentVar,
    CellVar,
    IterationScope,
    NotSupported,
    scope_of_agents,
)
from sjdsl.compiler.lower.state_reads import HEADING, POSITION
from sjdsl.compiler.lower.writer import Writer
from sjdsl.compiler.program.expressions import (
    Call,
    Cast,
    Expression,
    Literal,
    Name,
    Where,
    call,
    reshaped,
    scalar,
)


def somebody_seen(planes: dict[str, Value], w: Writer) -> Value:
    """Returns on which cells of the windows an agent stands, also the observer itself."""
    return w.keep("somebody", planes["agent"].ne(0))


def without_hidden_marks(planes: dict[str, Value], axes: Axes, w: Writer) -> Value:
    """Returns the marks of each cell as bits, without those that are hidden from the observer."""
    marks = planes["marks"]
    all_hidden = w.game.hidden
    by_kind = {look.kind.name: look for look in looks(w.game) if look.present}
    raw = planes["content"]
    if any(hidden.on == "cells" for hidden in all_hidden):
        raw = w.keep("raw", raw)
    for hidden in all_hidden:
        if hidden.on == "agents":
            if hidden.what == "marks":
                marks = select(somebody_seen(planes, w), 0, marks)
            continue
        # On cells, only marks can be hidden.
        for kind in hidden.kinds:
            if kind in by_kind:
                w.origin = hidden.origin
                is_hidden = _is_hidden_on(by_kind[kind], hidden, raw, axes, w)
                marks = w.keep("marks", select(is_hidden, 0, marks))
    return marks


def _is_hidden_on(look: Look, hidden: ir.Hidden, raw: Value, axes: Axes, w: Writer) -> Value:
    """Returns on which cells of the windows a `hide marks on KIND when ...` hides them.

    raw: the cells as painted.
    """
    is_kind, values = look_fields(look, raw, w)
    if hidden.when is None:
        return is_kind
    return is_kind & w.value(hidden.when, seen_cell(look, hidden.name, values, axes))


def look_fields(look: Look, raw: Value, w: Writer) -> tuple[Value, dict[str, Value]]:
    """Returns which cells are of a kind, and the values of its painted fields by name.

    Where another kind is, the values mean nothing. raw: the cells as painted.
    """
    name = look.kind.name
    first = first_look(look, w)
    if not look.painted:
        return w.keep(f"is_{name}", raw.eq(first)), {}
    fields = [field.name for field, _ in look.painted]
    sizes = tuple(size for _, size in look.painted)
    parts = call("look_fields", raw.node, first.node, sizes)
    names = [f"{name}_{field}" for field in fields]
    is_kind, *nodes = w.keep_parts((f"is_{name}", *names), parts)
    values = [replace(raw, node=node) for node in nodes]
    return replace(raw, node=is_kind, dtype="bool"), dict(zip(fields, values, strict=True))


def seen_cell(look: Look, name: str, values: dict[str, Value], axes: Axes) -> IterationScope:
    """Returns the scope of a condition on `agent`, the observer, and a cell that it sees.

    Args:
      name: of the cell in the condition.
      values: its painted fields, which so need not be looked up.
    """
    painted = tuple(values.items())
    cell = CellVar(literal(0, "i32"), (look.kind.name,), painted=painted, seen=axes)
    return scope_of_agents(axes).binding(name, cell)


def observe(w: Writer) -> Expression:
    """Writes the statements of `observe`; returns the observation."""
    game = w.game
    heading = seen_heading(game)
    is_sometimes_hidden = heading is not None and heading.hidden_when is not None
    # Whether each cell has the number of the agent on it, to look up what is shown of that agent.
    by_id = is_sometimes_hidden or any(s.what == "other" for s in game.observables)
    parts = parts_of(game, by_id)
    painted = paint_planes(parts, by_id, w)
    num_cells = prod(view_size(game))
    observer = w.axis("observer", w.module.agents)
    size = w.module.number("num_view_cells", num_cells, "cells of a window")
    axes = (observer, w.axis("seen", size))
    w.origin = game.window.origin
    seen = _own_windows(_cut_windows(painted, w), axes, w)
    planes = {part.name: _part_of(part, parts, seen[part.plane], axes, w) for part in parts}
    content = w.keep("content", _content(planes["content"], axes, w))
    agents = _agents(planes["agent"], axes, by_id, w)
    if any(hidden.what == "content" for hidden in game.hidden):
        covered = literal(content_labels(game).index(COVERED), "u8")
        content = select(somebody_seen(planes, w), covered, content)
    columns = [content, *agents]
    if "marks" in planes:
        columns.insert(2, w.keep("marks", without_hidden_marks(planes, axes, w)))
    columns += _movers(planes, axes, w)
    columns += _everyone(axes, w)
    columns += _own(axes, w)
    is_present = state_reads.present(AgentVar(iota(observer), observer), w)
    present = Literal(None) if is_present == TRUE else is_present.node
    full = [_full(column, axes) for column in columns]
    return call("planes_of", Name("WINDOW"), present, *full)


def _cut_windows(painted: list[Name], w: Writer) -> list[Name]:
    """Writes the windows of all observers, of each painted plane."""
    sides = []
    for side in ("ahead", "behind", "left", "right"):
        cells = getattr(w.game.window, side)
        sides.append((side, w.module.number(side, cells, "cells of a window")))
    seen = []
    for number, plane in enumerate(painted):
        frame: Expression = reshaped(plane, Name("FRAME"))
        if w.layout.wraps:
            frame = call("joined_edges", frame, Name("PAD"))
        windows = Call(Name("windows"), (frame, POSITION, HEADING), tuple(sides))
        seen.append(w.bind(f"seen_{number}", windows))
    return seen


def _own_windows(seen: list[Name], axes: Axes, w: Writer) -> list[Name]:
    """Returns the painted planes as each agent's own window has them.

    Beyond it everything is as off the map.
    """
    views = w.game.window.views
    if not views:
        return seen
    place = scope_of_agents(axes[:1])
    inside = TRUE  # replaced by the last view, which has no condition
    for number, view in reversed(list(enumerate(views))):
        w.origin = view.origin
        table = w.layout.view_cells_table(view)
        mask = w.module.constant(f"view_{number}", table, "cells of one of the windows")
        cells = Value(mask, "bool", axes[1:])
        if view.condition is None:
            inside = cells
        else:
            inside = select(_condition(view.condition, place, w), cells, inside)
    inside = w.keep("in_window", inside)
    windows = []
    for name in seen:
        visible = select(inside, Value(name, "u8", axes), 0)
        windows.append(w.bind(name.identifier, visible.node))
    return windows


def _myself(w: Writer) -> Expression:
    """Returns which cell of its window is the observer's own."""
    if w.layout.shows_cells_twice:
        comment = "which cells of its window show the observer's own"
        table = w.module.constant("myself", w.layout.own_cells_table, comment)
        return table[HEADING]
    game = w.game
    own_cell = call("own_cell", *view_size(game), game.window.ahead, game.window.left)
    comment = "which cell of its window is the observer's own"
    return w.module.constant("myself", own_cell, comment)[None]


def _standing(plane: Value, name: str, entity_type: ir.EntityType, w: Writer) -> AgentVar:
    """Returns who stands on each cell, from a plane of numbers one up.

    Where nobody does it is the first of all.
    """
    index = called("jnp.maximum", as_dtype(plane, "i32") - 1, 0)
    return AgentVar(w.keep(name, index), entity_type=entity_type)


def _part_of(part: Part, parts: tuple[Part, ...], seen: Expression, axes: Axes, w: Writer) -> Value:
    """Returns the numbers of a part. seen: the windows of its plane."""
    shifted = Value(seen, "u8", axes) >> shift_of(part, w)
    is_alone = all(other is part or other.plane != part.plane for other in parts)
    if is_alone:
        return shifted
    return shifted & w.module.number(f"{part.name}_mask", 2**part.bits - 1)


def _full(column: Value, axes: Axes) -> Expression:
    """Returns a plane at the full length of all axes, as uint8."""
    if column.literal:
        column = replace(column, node=scalar(column.node, "u8"))
    return spread(column, axes)


def _content(raw: Value, axes: Axes, w: Writer) -> Value:
    """Returns what is in each cell as each observer is shown it. raw: as it is painted."""
    game = w.game
    present = [look for look in looks(game) if look.present]
    if all(look.same and look.raw == look.final for look in present):
        return raw
    raw = w.keep("raw", raw)
    # Numbers that are shown as painted, but for a shift, are shown by ranges: (test, shown) pairs.
    arms = []
    shown = raw
    shift = 0
    for look in present:
        # Looks before this one may show more or fewer values than are painted.
        if look.same and look.final - look.raw != shift:
            arms.append((raw < first_look(look, w), shown))
            shift = look.final - look.raw
            shown = _shifted(raw, shift, look.kind.name, w)
    shown = first_of(arms, shown, w)
    # The looks of other kinds are computed from their fields.
    for look in present:
        if not look.same:
            is_kind, values = look_fields(look, raw, w)
            shown = w.keep("content", select(is_kind, _shown(look, values, axes, w), shown))
    return shown


def _shifted(raw: Value, shift: int, kind: str, w: Writer) -> Value:
    """Returns the painted numbers plus the shift that holds from a kind on."""
    if shift == 0:
        return raw
    if shift > 0:
        comment = f"added to what is painted, from {kind} on"
        return raw + w.module.number(f"{kind}_up", shift, comment)
    comment = f"taken from what is painted, from {kind} on"
    return raw - w.module.number(f"{kind}_down", -shift, comment)


def _shown(look: Look, values: dict[str, Value], axes: Axes, w: Writer) -> Value:
    """Returns the number that each observer is shown for cells of a kind.

    values: the kind's painted fields.
    """
    name = look.kind.name
    place = seen_cell(look, name, values, axes)
    if look.labels:
        numbers = dict(zip(look.final_words[0], look.labels, strict=True))
        return _labelled(look.observables[0], numbers, place, w)
    first = Value(w.module.number(f"{name}_shown", look.final, "as it is shown"), "u8")
    if not look.observables:  # a kind of which only marks are seen has one look
        return first
    seen = []
    for observable, words in zip(look.observables, look.final_words, strict=True):
        shown = _observable(observable, words, values, place, w)
        seen.append(w.keep(f"shown_{observable.field}", shown))
    return look_number(first, tuple(map(len, look.final_words)), seen)


def _labelled(
    observable: ir.Observable, numbers: dict[str, int], place: IterationScope, w: Writer
) -> Value:
    """Returns the number of the first label whose condition holds, else that of the last.

    numbers: label -> its number.
    """
    arms = []
    for label in reversed(observable.labels):  # written in the order in which the selects nest
        if label.condition is not None:
            number = literal(numbers[label.name], "u8")
            arms.append((_condition(label.condition, place, w), number))
    last = literal(numbers[observable.labels[-1].name], "u8")
    return first_of(arms[::-1], last, w)


def _observable(
    observable: ir.Observable,
    words: tuple[str, ...],
    values: dict[str, Value],
    place: IterationScope,
    w: Writer,
) -> Value:
    """Returns the number of what is shown of a cell, among `words`."""
    if observable.labels:
        numbers = {word: number for number, word in enumerate(words)}
        shown = _labelled(observable, numbers, place, w)
    else:
        shown = values[observable.field]
    if observable.hidden_when is not None:
        is_hidden = _condition(observable.hidden_when, place, w)
        shown = select(is_hidden, len(words) - 1, shown)
    return shown


def _condition(test: ir.Expr, place: IterationScope, w: Writer) -> Value:
    """Returns a condition; what is not supported in it is reported there."""
    try:
        return w.value(test, place)
    except NotSupported as refused:
        refused.origin = refused.origin or test.origin
        raise


def _agents(agent: Value, axes: Axes, by_id: bool, w: Writer) -> list[Value]:
    """Returns the plane of agents, then one for each field that is shown of the others."""
    is_self = _myself(w)
    agent = w.keep("agent", agent)
    somebody = agent.ne(0).node
    if w.layout.shows_cells_twice:  # the observer's own cell is seen only inside its window
        is_self = is_self & somebody
    heading = seen_heading(w.game)
    if not by_id and heading is None:
        return [_agent_plane(is_self, somebody, Literal(OTHER_FACING), axes, w)]
    if not by_id:
        observers = Cast(HEADING, "u8")[:, None]
        difference = agent.node - 1 - observers
        other = w.keep_node("others", relative_heading(difference, OTHER_FACING), "u8")
        return [_agent_plane(is_self, somebody, other, axes, w)]
    standing = _standing(agent, "who", AGENTS, w)
    place = scope_of_agents(axes).binding("other", standing)
    others = Literal(OTHER_FACING) if heading is None else _headings(heading, standing, place, w)
    columns = [_agent_plane(is_self, somebody, others, axes, w)]
    is_other = somebody & ~is_self
    theirs = w.keep("theirs", Value(is_other, "bool", axes))
    for observable in _shown_of("other", w):
        value = _one_up(observable, _field_observable(observable, standing, place, w))
        columns.append(_visible(observable, value, place, w, theirs))
    return columns


def _headings(
    heading: ir.Observable, standing: AgentVar, place: IterationScope, w: Writer
) -> Expression:
    """Returns the numbers of others in the plane of agents: by heading, unless that is hidden."""
    difference = HEADING[standing.number.node] - HEADING[:, None]
    numbers = Cast(relative_heading(difference, OTHER_FACING), "u8")
    if heading.hidden_when is None:
        return numbers
    faceless = len(agent_labels(w.game)) - 1
    is_hidden = _condition(heading.hidden_when, place, w)
    return select(is_hidden, faceless, Value(numbers, "u8", place.axes)).node


def _shown_of(what: str, w: Writer) -> list[ir.Observable]:
    """Returns what is shown of others, of movers, of everyone, of the observer or of the world."""
    return [observable for observable in w.game.observables if observable.what == what]


def _one_up(observable: ir.Observable, value: Value) -> Value:
    """Returns an enum value's number plus 1, as 0 says that nobody is there; numbers stay."""
    if observable.labels or observable.type.kind == "word":
        return value + 1
    return value


def _visible(
    observable: ir.Observable, value: Value, place: IterationScope, w: Writer, exists: Value = TRUE
) -> Value:
    """Returns what is seen of somebody; 0 where nobody is.

    Where it is hidden it is 0; where a condition for showing it doesn't hold, it is the enum value
    `hidden`, which comes last, or 0 if it is a number.
    """
    hidden_when = observable.hidden_when
    if observable.shown_when is None:
        value = select(exists, value, 0)
        if hidden_when is None:
            return value
        return select(w.value(hidden_when, place), 0, value)
    words = shown_words(observable)
    hidden = 0
    if words:
        is_one_up = observable.what in ("other", "mover")
        hidden = len(words) - 1 + is_one_up
    is_shown = w.value(observable.shown_when, place)
    if hidden_when is not None:
        is_shown = is_shown & ~w.value(hidden_when, place)
    return select(exists, select(is_shown, value, hidden), 0)


def _agent_plane(
    is_self: Expression,
    somebody: Expression,
    other: Expression,
    axes: Axes,
    w: Writer,
) -> Value:
    """Returns the plane of agents: 1 for the observer, 0 for nobody, and numbers for others."""
    others = Where(somebody, other, Literal(0))
    plane = Cast(Where(is_self, Literal(1), others), "u8")
    return w.keep("agents", Value(plane, "u8", axes))


def _field_observable(
    observable: ir.Observable, body: AgentVar | None, place: IterationScope, w: Writer
) -> Value:
    """Returns what is shown, as a byte: a label, an attribute, a `define` or a field.

    body: whose it is, None for the world's.
    """
    if observable.labels:
        names = dict.fromkeys(label.name for label in observable.labels)
        return _labelled(observable, {name: number for number, name in enumerate(names)}, place, w)
    if shows_attribute(observable):
        return _attribute_observable(observable, place, w)
    if observable.value is not None:
        return as_dtype(w.value(observable.value, place), "u8")
    declared = shown_field(w.game, observable)
    read = ir.FieldRead(
        type=declared.type, owner=None, held_by=declared.held_by, name=observable.field
    )
    stored = state_reads.field(read, body, w)
    if observable.word is not None:
        stored = taken(stored, w.module.entry(observable.word).node)
    is_small = declared.type.kind == "int" and state_reads.fits_byte(declared, w)
    if stored.dtype != "u8" and not is_small:
        stored = called("jnp.minimum", stored, 255)
    return as_dtype(stored, "u8")


def _attribute_observable(observable: ir.Observable, place: IterationScope, w: Writer) -> Value:
    """Returns an attribute of an agent as a byte; the row and column of one that is away are 0."""
    owner = observable.owner
    assert owner is not None, observable
    read = ir.Attribute(type=observable.type, owner=owner, name=observable.field)  # type: ignore[arg-type]
    value = w.value(read, place)
    if observable.field in ("row", "col"):
        is_present = state_reads.present(agent_of(owner, place, w), w)
        value = select(is_present, value, 0)
    return as_dtype(value, "u8")


def _movers(planes: dict[str, Value], axes: Axes, w: Writer) -> list[Value]:
    """Returns the planes of movers: where they are, then one for each field shown of them."""
    columns = []
    for observable in _shown_of("mover", w):
        w.origin = observable.origin
        painted = planes[observable.kind]
        exists = painted.ne(0)
        mover = _standing(painted, f"which_{observable.kind}", observable.entity_type, w)
        place = scope_of_agents(axes).binding(observable.kind, mover)
        if not observable.field:
            value = as_dtype(exists, "u8")
        elif observable.field == "heading" and not observable.labels:
            difference = state_reads.heading(mover, w).node - HEADING[:, None]
            value = Value(Cast(relative_heading(difference, 1), "u8"), "u8", axes)
        else:
            value = _one_up(observable, _field_observable(observable, mover, place, w))
        visible = _visible(observable, value, place, w, exists)
        columns.append(w.keep(f"seen_{observable.kind}", visible))
    return columns


def _everyone(axes: Axes, w: Writer) -> list[Value]:
    """Returns what is shown of every agent: for each field a plane an agent, by their numbers."""
    columns = []
    observer, window = axes
    pair = (observer, w.axis("everyone", w.module.agents))
    body = AgentVar(iota(pair[1]), pair[1])
    place = scope_of_agents(pair).binding("everyone", body)
    for observable in _shown_of("everyone", w):
        w.origin = observable.origin
        value = _visible(observable, _field_observable(observable, body, place, w), place, w)
        value = w.keep(f"everyone_{observable.field}", value)
        planes = reshaped(_full(value, (*pair, window)), observer.extent, -1)
        columns.append(Value(planes, "u8", axes))
    return columns


def _own(axes: Axes, w: Writer) -> list[Value]:
    """Returns the planes of the observer's own fields and the world's."""
    columns = []
    observer = AgentVar(iota(axes[0]), axes[0])
    place = scope_of_agents(axes[:1])
    for observable in (*_shown_of("own", w), *_shown_of("world", w)):
        w.origin = observable.origin
        body = observer if observable.what == "own" else None
        value = _field_observable(observable, body, place, w)
        visible = _visible(observable, value, place, w)
        columns.append(w.keep(f"shown_{observable.field}", visible))
    return columns

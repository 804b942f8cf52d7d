"""Lowers `observe`: paints the map once, cuts it into egocentric windows, and decodes each byte into observation planes."""

from dataclasses import replace
from math import prod

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import shown_field, shows_attribute, view_size
from sjdsl.compiler.ir.sorts import AGENTS
from sjdsl.compiler.lower import state_reads
from sjdsl.compiler.lower.axes import (
    TRUE,
    Axis,
    Value,
    as_dtype,
    binary,
    both,
    invert,
    iota,
    literal,
    select,
    spread,
    taken,
)
from sjdsl.compiler.lower.cell_appearance import (
    COVERED,
    Look,
    content_labels,
    looks,
    relative_heading,
    shown_words,
)
from sjdsl.compiler.lower.expressions import agent as agent_of
from sjdsl.compiler.lower.expressions import first_of
from sjdsl.compiler.lower.painting import (
    HEADING,
    POSITION,
    Part,
    first_look,
    look_number,
    paint_planes,
    parts_of,
    shift_of,
)
from sjdsl.compiler.lower.scope import AgentVar, CellVar, IterationScope, NotSupported, Variable
from sjdsl.compiler.lower.writer import Writer
from sjdsl.compiler.program import expressions as array


def marks_seen(
    marks: list[Part], planes: dict[str, Value], seen: list[array.Name], w: Writer
) -> Value:
    """Returns the marks of a cell as bits, one a phase."""
    first = planes[marks[0].name]
    if len(marks) == 1:
        return first
    if all(
        m.plane == marks[0].plane and m.shift == marks[0].shift + i for i, m in enumerate(marks)
    ):
        shifted = binary(
            ">>",
            replace(first, node=seen[marks[0].plane]),
            Value(w.module.number("mark_shift", marks[0].shift), "u8"),
            "u8",
        )
        return binary(
            "&", shifted, Value(w.module.number("mark_mask", 2 ** len(marks) - 1), "u8"), "u8"
        )
    result = first
    for place, m in enumerate(marks[1:], 1):
        result = binary("|", result, binary("<<", planes[m.name], literal(place, "u8"), "u8"), "u8")
    return result


def somebody_seen(planes: dict[str, Value], w: Writer) -> Value:
    """Returns where an agent stands, the observer too."""
    return w.keep("somebody", binary("!=", planes["agent"], literal(0, "u8"), "bool"))


def without_hidden_marks(
    marks: Value, planes: dict[str, Value], axes: tuple[Axis, ...], w: Writer
) -> Value:
    """Returns the marks that are seen: none on the cells on which they are hidden."""
    found = {look.kind.name: look for look in looks(w.module.game) if look.present}
    raw = (
        w.keep("raw", planes["content"])
        if any(h.on == "cells" for h in w.module.game.hidden)
        else planes["content"]
    )
    for hidden in w.module.game.hidden:
        if hidden.what == "marks" and hidden.on == "agents":
            marks = select(somebody_seen(planes, w), literal(0, "u8"), marks)
        for look in (found[kind] for kind in hidden.kinds if kind in found):
            w.origin = hidden.origin
            there, values = look_fields(look, raw, w)
            if hidden.when is not None:
                there = binary(
                    "&",
                    there,
                    w.value(hidden.when, seen_cell(look, hidden.name, values, axes)),
                    "bool",
                )
            marks = w.keep("marks", select(there, literal(0, "u8"), marks))
    return marks


def look_fields(look: Look, raw: Value, w: Writer) -> tuple[Value, dict[str, Value]]:
    """Returns which numbers of looks are of a kind, and the values of its painted fields, which mean nothing where another kind is."""
    name, first = look.kind.name, first_look(look, w)
    if not look.painted:
        return w.keep(f"is_{name}", binary("==", raw, first, "bool")), {}
    fields, sizes = zip(*((field.name, size) for field, size in look.painted), strict=True)
    call = array.call("look_fields", raw.node, first.node, array.constant(sizes))
    there, *values = w.keep_parts((f"is_{name}", *(f"{name}_{field}" for field in fields)), call)
    return replace(raw, node=there, dtype="bool"), {
        field: replace(raw, node=value) for field, value in zip(fields, values, strict=True)
    }


def seen_cell(
    look: Look, name: str, values: dict[str, Value], axes: tuple[Axis, ...]
) -> IterationScope:
    """Returns the scope of a condition about the observer and the cell that it sees: what was painted of it need not be looked up."""
    return _seen_by(
        axes,
        **{name: CellVar(literal(0, "i32"), (look.kind.name,), None, tuple(values.items()), axes)},
    )


def _seen_by(axes: tuple[Axis, ...], **others: Variable) -> IterationScope:
    """Returns the scope of a condition about the observer, the first axis, and others."""
    return IterationScope(
        axes=axes, variables={"agent": AgentVar(iota(axes[0]), axes[0]), **others}
    )


def observe(w: Writer) -> array.Expression:
    """Writes the statements of `observe`; returns the observation."""
    game = w.module.game
    by_id = any(s.what == "other" for s in game.observables)
    parts = parts_of(game, by_id)
    painted = paint_planes(parts, by_id, w)
    observer, size = (
        w.axis("observer", w.module.agents),
        w.module.number("num_view_cells", prod(view_size(game)), "cells of a window"),
    )
    axes, window = (observer, w.axis("seen", size)), game.window
    w.origin = window.origin
    sides = (
        ("ahead", window.ahead),
        ("behind", window.behind),
        ("left", window.left),
        ("right", window.right),
    )
    cut = tuple((name, w.module.number(name, reach, "cells of a window")) for name, reach in sides)
    seen = []
    for number, plane in enumerate(painted):
        frame: array.Expression = array.Call(
            array.Attribute(plane, "reshape"), (array.Name("FRAME"),)
        )
        if w.module.layout.wraps:
            frame = array.call("joined_edges", frame, array.Name("PAD"))
        seen.append(
            w.bind(
                f"seen_{number}", array.Call(array.Name("windows"), (frame, POSITION, HEADING), cut)
            )
        )
    seen = _own_windows(seen, axes, w)
    planes = {part.name: _part_of(part, parts, seen[part.plane], axes, w) for part in parts}
    columns = [
        w.keep("content", _content(planes["content"], axes, w)),
        *_agents(planes["agent"], axes, by_id, w),
    ]
    if any(hidden.what == "content" for hidden in game.hidden):
        columns[0] = select(
            somebody_seen(planes, w), literal(content_labels(game).index(COVERED), "u8"), columns[0]
        )
    marks = [p for p in parts if p.marks is not None]
    if marks:
        columns.insert(
            2,
            w.keep(
                "marks", without_hidden_marks(marks_seen(marks, planes, seen, w), planes, axes, w)
            ),
        )
    columns += [*_movers(planes, axes, w), *_everyone(axes, w), *_own(axes, w)]
    away = state_reads.present(AgentVar(iota(axes[0]), axes[0]), w)
    present = array.Literal(None) if away == TRUE else away.node
    return array.call(
        "planes_of", array.Name("WINDOW"), present, *(_full(c, axes) for c in columns)
    )


def _own_windows(seen: list[array.Name], axes: tuple[Axis, ...], w: Writer) -> list[array.Name]:
    """Returns the painted planes as each agent's own window has them: beyond it all is as off the map."""
    views = w.module.game.window.views
    if not views:
        return seen
    place = _seen_by(axes[:1])
    inside = TRUE  # the last one has no condition
    for number, view in reversed(list(enumerate(views))):
        w.origin = view.origin
        table = w.module.layout.view_cells_table(view)
        cells = Value(
            w.module.constant(f"view_{number}", table, "cells of one of the windows"),
            "bool",
            axes[1:],
        )
        inside = (
            cells
            if view.condition is None
            else select(_asked(view.condition, place, w), cells, inside)
        )
    inside = w.keep("in_window", inside)
    return [
        w.bind(name.identifier, select(inside, Value(name, "u8", axes), literal(0, "u8")).node)
        for name in seen
    ]


def _myself(w: Writer) -> array.Expression:
    """Returns which cell of its window is the observer's own."""
    window = w.module.game.window
    if w.module.layout.shows_cells_twice:
        table = w.module.constant(
            "myself",
            w.module.layout.own_cells_table,
            "which cells of its window show the observer's own",
        )
        return array.Index(table, (HEADING,))
    own = array.call(
        "own_cell", *map(array.constant, (*view_size(w.module.game), window.ahead, window.left))
    )
    myself = w.module.constant("myself", own, "which cell of its window is the observer's own")
    return array.Index(myself, (array.NEW_AXIS,))


def _standing(plane: Value, name: str, sort: ir.Sort, w: Writer) -> AgentVar:
    """Returns who stands on each cell (the first one where nobody does), from a plane of numbers one up."""
    who = array.Binary("-", array.Cast(plane.node, "i32"), array.Literal(1))
    return AgentVar(
        w.keep(name, Value(array.call("jnp.maximum", who, array.Literal(0)), "i32", plane.axes)),
        sort=sort,
    )


def _part_of(
    part: Part, parts: tuple[Part, ...], seen: array.Expression, axes: tuple[Axis, ...], w: Writer
) -> Value:
    """Returns a part of a byte that was painted."""
    whole = binary(">>", Value(seen, "u8", axes), shift_of(part, w), "u8")
    if sum(p.plane == part.plane for p in parts) == 1:
        return whole
    return binary(
        "&", whole, Value(w.module.number(f"{part.name}_mask", 2**part.bits - 1), "u8"), "u8"
    )


def _full(column: Value, axes: tuple[Axis, ...]) -> array.Expression:
    """Returns a value spelt out over axes: a column over the window."""
    return spread(
        replace(column, node=array.scalar(column.node, "u8")) if column.literal else column, axes
    )


def _content(raw: Value, axes: tuple[Axis, ...], w: Writer) -> Value:
    """Returns the content as each observer is shown it."""
    game = w.module.game
    found = [look for look in looks(game) if look.present]
    if all(look.same and look.raw == look.final for look in found):
        return raw
    raw = w.keep("raw", raw)
    arms, shown, shift = [], raw, 0
    for look in (
        look for look in found if look.same
    ):  # those before this one may show more or fewer values than are painted
        if look.final - look.raw != shift:
            arms.append((binary("<", raw, first_look(look, w), "bool"), shown))
            shift = look.final - look.raw
            shown = _shifted(raw, shift, look.kind.name, w)
    shown = first_of(arms, shown, w)
    for look in found:
        if not look.same:
            is_kind, values = look_fields(look, raw, w)
            shown = w.keep("content", select(is_kind, _shown(look, values, axes, w), shown))
    return shown


def _shifted(raw: Value, shift: int, kind: str, w: Writer) -> Value:
    """Returns the numbers that are shown of a kind and those after it, from the painted ones."""
    if shift == 0:
        return raw
    name, comment = ("up", "added to") if shift > 0 else ("down", "taken from")
    by = w.module.number(f"{kind}_{name}", abs(shift), f"{comment} what is painted, from {kind} on")
    return binary("+" if shift > 0 else "-", raw, Value(by, "u8"), "u8")


def _shown(look: Look, values: dict[str, Value], axes: tuple[Axis, ...], w: Writer) -> Value:
    """Returns the number of a kind's look for each observer, from its painted values."""
    place = seen_cell(look, look.kind.name, values, axes)
    if look.labels:
        return _labelled(
            look.observables[0], dict(zip(look.final_words[0], look.labels, strict=True)), place, w
        )
    first = Value(w.module.number(f"{look.kind.name}_shown", look.final, "as it is shown"), "u8")
    if not look.observables:  # a kind of which only marks are seen has one look
        return first
    seen = [
        w.keep(f"shown_{observable.field}", _observable(observable, words, values, place, w))
        for observable, words in zip(look.observables, look.final_words, strict=True)
    ]
    return look_number(first, tuple(map(len, look.final_words)), seen)


def _labelled(
    observable: ir.Observable, numbers: dict[str, int], place: IterationScope, w: Writer
) -> Value:
    """Returns the number of the first label whose condition holds, else that of the last."""
    number = {label.name: literal(numbers[label.name], "u8") for label in observable.labels}
    shown = [(label.condition, number[label.name]) for label in observable.labels]
    # Emitted last to first, the order in which the selects nest; `first_of` wants them in the order of the labels.
    arms = [
        (_asked(condition, place, w), value)
        for condition, value in reversed(shown)
        if condition is not None
    ]
    return first_of(arms[::-1], number[observable.labels[-1].name], w)


def _observable(
    observable: ir.Observable,
    words: tuple[str, ...],
    values: dict[str, Value],
    place: IterationScope,
    w: Writer,
) -> Value:
    if observable.labels:
        result = _labelled(
            observable, {word: number for number, word in enumerate(words)}, place, w
        )
    else:
        result = values[observable.field]
    if observable.hidden_when is not None:
        result = select(
            _asked(observable.hidden_when, place, w), literal(len(words) - 1, "u8"), result
        )
    return result


def _asked(test: ir.Expr, place: IterationScope, w: Writer) -> Value:
    """Returns what a label or `hide` asks; its place is that of what cannot be asked."""
    try:
        return w.value(test, place)
    except NotSupported as refused:
        refused.origin = refused.origin or test.origin
        raise


def _agents(agent: Value, axes: tuple[Axis, ...], by_id: bool, w: Writer) -> list[Value]:
    """Returns the plane of agents, then one for each thing shown of the others."""
    game = w.module.game
    self_ = _myself(w)
    agent = w.keep("agent", agent)
    somebody = binary("!=", agent, literal(0, "u8"), "bool").node
    if (
        w.module.layout.shows_cells_twice
    ):  # the observer's own cell is seen only inside its own window
        self_ = array.Binary("&", self_, somebody)
    if not by_id:
        mine = array.Index(array.Cast(HEADING, "u8"), (array.ALL, array.NEW_AXIS))
        difference = array.Binary("-", array.Binary("-", agent.node, array.Literal(1)), mine)
        other = w.keep("others", Value(relative_heading(difference), "u8", axes)).node
        return [_agent_plane(self_, somebody, other, axes, w)]
    standing = _standing(agent, "who", AGENTS, w)
    place = _seen_by(axes, other=standing)
    turned = array.Binary(
        "-",
        array.Index(HEADING, (standing.index.node,)),
        array.Index(HEADING, (array.ALL, array.NEW_AXIS)),
    )
    columns = [_agent_plane(self_, somebody, array.Cast(relative_heading(turned), "u8"), axes, w)]
    theirs = w.keep(
        "theirs", Value(array.Binary("&", somebody, array.Unary("~", self_)), "bool", axes)
    )
    for observable in game.observables:
        if observable.what == "other":
            columns.append(
                _visible(
                    observable,
                    _one_up(observable, _field_observable(observable, standing, place, w)),
                    place,
                    w,
                    theirs,
                )
            )
    return columns


def _one_up(observable: ir.Observable, value: Value) -> Value:
    """Returns a word's number one up, since 0 says that nobody is there; numbers stay."""
    return (
        binary("+", value, literal(1, "u8"), "u8")
        if observable.labels or observable.type.kind == "word"
        else value
    )


def _visible(
    observable: ir.Observable, value: Value, place: IterationScope, w: Writer, there: Value = TRUE
) -> Value:
    """Returns what is seen of somebody: 0 where nobody is `there`, and where the rules do not show it 0, or the word `hidden`."""
    hides = observable.hidden_when
    if observable.shown_when is not None:
        words = shown_words(observable)
        hidden = literal(
            len(words) - 1 + (observable.what in ("other", "mover")) if words else 0, "u8"
        )
        shown = w.value(observable.shown_when, place)
        shown = shown if hides is None else both(shown, invert(w.value(hides, place)))
        return select(there, select(shown, value, hidden), literal(0, "u8"))
    value = select(there, value, literal(0, "u8"))
    return value if hides is None else select(w.value(hides, place), literal(0, "u8"), value)


def _agent_plane(
    self_: array.Expression,
    somebody: array.Expression,
    other: array.Expression,
    axes: tuple[Axis, ...],
    w: Writer,
) -> Value:
    """Returns the plane of agents: 1 for the observer, 0 where nobody is, and numbers for others."""
    seen = array.Cast(
        array.Where(self_, array.Literal(1), array.Where(somebody, other, array.Literal(0))), "u8"
    )
    return w.keep("agents", Value(seen, "u8", axes))


def _field_observable(
    observable: ir.Observable, who: AgentVar | None, place: IterationScope, w: Writer
) -> Value:
    """Returns the value of a shown field as a byte."""
    if observable.labels:
        names = dict.fromkeys(label.name for label in observable.labels)
        return _labelled(observable, {name: number for number, name in enumerate(names)}, place, w)
    if shows_attribute(observable):
        owner = observable.owner
        assert owner is not None, observable
        value = w.value(
            ir.Attribute(type=observable.type, owner=owner, name=observable.field), place
        )  # type: ignore[arg-type]
        if observable.field in ("row", "col"):
            value = select(
                state_reads.present(agent_of(owner, place, w), w), value, literal(0, "i32")
            )
        return as_dtype(value, "u8")
    if observable.value is not None:
        return as_dtype(w.value(observable.value, place), "u8")
    declared = shown_field(w.module.game, observable)
    read = ir.FieldRead(
        type=declared.type, owner=None, held_by=declared.held_by, name=observable.field
    )
    stored = state_reads.field(read, who, w)
    if observable.word is not None:
        stored = taken(stored, w.module.entry(observable.word).node)
    if stored.dtype == "u8":
        return stored
    if declared.type.kind != "int" or not state_reads.fits_byte(declared, w):
        stored = replace(stored, node=array.call("jnp.minimum", stored.node, array.Literal(255)))
    elif (
        isinstance(stored.node, array.Cast) and stored.node.source == "u8"
    ):  # it was widened from the byte that is wanted
        return replace(stored, node=stored.node.value, dtype="u8")
    return replace(stored, node=array.Cast(stored.node, "u8"), dtype="u8")


def _movers(planes: dict[str, Value], axes: tuple[Axis, ...], w: Writer) -> list[Value]:
    """Returns the planes of movers: for each sort where they are, then one for each thing shown of them."""
    columns = []
    for observable in (s for s in w.module.game.observables if s.what == "mover"):
        w.origin = observable.origin
        painted = planes[observable.kind]
        there = binary("!=", painted, literal(0, "u8"), "bool")
        mover = _standing(painted, f"which_{observable.kind}", observable.sort, w)
        place = _seen_by(axes, **{observable.kind: mover})
        if not observable.field:
            value = as_dtype(there, "u8")
        elif observable.field == "heading" and not observable.labels:
            turned = array.Binary(
                "-",
                state_reads.heading(mover, w).node,
                array.Index(HEADING, (array.ALL, array.NEW_AXIS)),
            )
            value = Value(
                array.Cast(
                    array.Binary(
                        "+", array.Binary("&", turned, array.Literal(3)), array.Literal(1)
                    ),
                    "u8",
                ),
                "u8",
                axes,
            )
        else:
            value = _one_up(observable, _field_observable(observable, mover, place, w))
        columns.append(
            w.keep(f"seen_{observable.kind}", _visible(observable, value, place, w, there))
        )
    return columns


def _everyone(axes: tuple[Axis, ...], w: Writer) -> list[Value]:
    """Returns what is shown of every agent: for each such thing a plane an agent, in the order of their numbers, side by side."""
    columns = []
    pair = (axes[0], w.axis("everyone", w.module.agents))
    who = AgentVar(iota(pair[1]), pair[1])
    place = _seen_by(pair, everyone=who)
    for observable in w.module.game.observables:
        if observable.what == "everyone":
            w.origin = observable.origin
            value = _visible(observable, _field_observable(observable, who, place, w), place, w)
            value = w.keep(f"everyone_{observable.field}", value)
            planes = _full(value, (*pair, axes[1]))
            columns.append(
                Value(
                    array.Call(
                        array.Attribute(planes, "reshape"), (axes[0].extent, array.Literal(-1))
                    ),
                    "u8",
                    axes,
                )
            )
    return columns


def _own(axes: tuple[Axis, ...], w: Writer) -> list[Value]:
    """Returns the planes of the observer's own fields and the world's."""
    columns = []
    observer, place = AgentVar(iota(axes[0]), axes[0]), _seen_by(axes[:1])
    shown = sorted(
        (s for s in w.module.game.observables if s.what in ("own", "world")), key=lambda s: s.what
    )
    for observable in shown:
        w.origin = observable.origin
        value = _field_observable(
            observable, observer if observable.what == "own" else None, place, w
        )
        columns.append(w.keep(f"shown_{observable.field}", _visible(observable, value, place, w)))
    return columns

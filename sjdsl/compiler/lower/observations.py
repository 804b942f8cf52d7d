"""Lowers `observe`: paints the map once, cuts it into egocentric windows, and decodes each byte into observation planes."""

from dataclasses import dataclass, replace

from sjdsl.compiler import ir
from sjdsl.compiler.ir.names import attribute_name
from sjdsl.compiler.lower import state_reads
from sjdsl.compiler.lower.axes import Axis, Value, binary, literal, select, wrapped
from sjdsl.compiler.lower.cell_appearance import COVERED, Look, content_labels, looks, seen_marks
from sjdsl.compiler.lower.expressions import lower, to_words
from sjdsl.compiler.lower.map_tables import Table
from sjdsl.compiler.lower.scope import AgentVar, CellVar, Frame, NotSupported, Writer, iota
from sjdsl.runtime.geometry import own_cell


@dataclass(frozen=True)
class Part:
    """Some bits of a painted byte."""

    name: str
    plane: int
    shift: int
    bits: int


def parts_of(game: ir.Game, by_id: bool) -> tuple[Part, ...]:
    """Returns where content, agents and marks are kept: packed into as few bytes as they fit."""
    contents = max(look.raw + look.raw_values for look in looks(game))
    wanted = [("content", _bits(contents)), ("agent", _bits(game.agents.number + 1) if by_id else 3)]
    wanted += [(f"mark_{p.name}", 1) for p in seen_marks(game)]
    found: list[Part] = []
    used = [0]
    for name, bits in wanted:
        plane = next((i for i, u in enumerate(used) if u + bits <= 8), len(used))
        if plane == len(used):
            used.append(0)
        found.append(Part(name, plane, used[plane], bits))
        used[plane] += bits
    return tuple(found)


def _bits(values: int) -> int:
    return max(1, (values - 1).bit_length())


def observe(w: Writer) -> str:
    """Writes the lines of `observe`; returns the text of the observation."""
    game = w.module.game
    by_id = any(s.what == "other" or (s.what == "heading" and s.hidden_when is not None) for s in game.sights)
    parts = parts_of(game, by_id)
    n, window = w.module.num_agents, game.window
    view = (window.ahead + 1 + window.behind, window.left + 1 + window.right)
    _paint(parts, by_id, w)
    cut = f"ahead={window.ahead}, behind={window.behind}, left={window.left}, right={window.right}"
    axes = (w.axis("observer", n), w.axis("seen", view[0] * view[1]))
    w.origin = window.origin
    planes: dict[str, Value] = {}
    num_planes = 1 + max(p.plane for p in parts)
    for plane in range(num_planes):
        frame = (w.module.layout.rows, w.module.layout.cols)
        w.line(f"seen_{plane} = windows(plane_{plane}.reshape{frame}, state.position, state.heading, {cut})")
    for part in parts:
        alone = sum(p.plane == part.plane for p in parts) == 1
        text = f"seen_{part.plane}"
        text = text if part.shift == 0 else f"({text} >> {part.shift})"
        planes[part.name] = Value(text if alone else f"{text} & {2**part.bits - 1}", "u8", axes)
    columns = [_content(planes["content"], axes, w), *_agents(planes["agent"], axes, by_id, w)]
    if any(hidden.what == "content" for hidden in game.hidden):
        columns[0] = select(_somebody(planes, w), literal(content_labels(game).index(COVERED), "u8"), columns[0])
    marks = [p for p in parts if p.name.startswith("mark_")]
    if marks:
        columns.insert(2, _without_hidden(_marks(marks, planes), planes, axes, w))
    columns += [*_everyone(axes, w), *_own(axes, w)]
    away = state_reads.present(AgentVar(iota(axes[0]), axes[0]), w)
    present = "None" if away is None else away.text
    return f"planes_of({view}, {present}, {', '.join(_full(c, axes) for c in columns)})"


def _full(column: Value, axes: tuple[Axis, ...]) -> str:
    """Returns a value spelt out over axes: a column over the window."""
    if column.axes == axes:
        return column.text
    shape = ", ".join(str(a.size) for a in axes)
    text = f"jnp.asarray({column.text}, jnp.uint8)" if column.literal else column.text
    if column.axes:
        text = f"{wrapped(column)}[{', '.join(':' if a in column.axes else 'None' for a in axes)}]"
    return f"jnp.broadcast_to({text}, ({shape}))"


def _paint(parts: tuple[Part, ...], by_id: bool, w: Writer) -> None:
    layout, game = w.module.layout, w.module.game
    content = next(p for p in parts if p.name == "content")
    base = layout.base_table({look.kind.name: look.raw << content.shift for look in looks(game)})
    name = w.module.constant("base", base, "looks of the cells of the frame, fields aside")
    for plane in range(1 + max(p.plane for p in parts)):
        w.line(f"plane_{plane} = {name if plane == content.plane else f'jnp.zeros({layout.rows * layout.cols}, jnp.uint8)'}")
    for look in looks(game):
        cells = layout.cells_table((look.kind.name,))
        if not look.painted or not len(cells.value):
            continue
        constant = w.module.constant(f"cells_{look.kind.name}", cells, f"cells of {look.kind.name}")
        w.origin = look.kind.origin
        value = wrapped(Value(_raw(look, w), "u8")) + (f" << {content.shift}" if content.shift else "")
        w.line(f"plane_{content.plane} = fill(plane_{content.plane}, {constant}, {value})")
    phases = {f"mark_{p.name}": p for p in seen_marks(game)}
    for part in parts:
        if part.name in phases:
            w.origin = phases[part.name].origin
            bit = 1 << part.shift
            w.line(f"plane_{part.plane} = paint(plane_{part.plane}, state.{part.name}, {bit})")
    w.origin = game.agents.origin
    agent = next(p for p in parts if p.name == "agent")
    if by_id:
        shown = f"(jnp.arange({w.module.num_agents}, dtype=jnp.uint8) + 1)"
    elif any(s.what == "heading" for s in game.sights):
        shown = "(state.heading.astype(jnp.uint8) + 1)"
    else:
        shown = f"jnp.ones({w.module.num_agents}, jnp.uint8)"
    shown += f" << {agent.shift}" if agent.shift else ""
    w.line(f"plane_{agent.plane} = paint(plane_{agent.plane}, state.position, {shown})")


def _raw(look: Look, w: Writer) -> str:
    """Returns the number of each cell's look: its fields' values, the first most significant."""
    text = ""
    for field, values in look.painted:
        stored = Value(f"state.{attribute_name(field)}", state_reads.storage(field, w))
        value = stored.text if stored.dtype == "u8" else f"{stored.text}.astype(jnp.uint8)"
        if field.type.kind == "agent":
            value = f"({stored.text} + 1).astype(jnp.uint8)"
        text = value if not text else f"({text}) * {values} + {value}"
    return f"{text} + {look.raw}"


def _content(raw: Value, axes: tuple[Axis, ...], w: Writer) -> Value:
    """Returns the content as each observer is shown it."""
    game = w.module.game
    found = [look for look in looks(game) if look.present]
    if all(look.same and look.raw == look.final for look in found):
        return raw
    raw = w.keep("raw", raw)
    shown, shift = raw, 0
    for look in (look for look in found if look.same):  # those before this one may show more or fewer values than are painted
        if look.final - look.raw != shift:
            step = binary(
                "*",
                Value(f"({raw.text} >= {look.raw}).astype(jnp.uint8)", "u8", axes),
                literal(look.final - look.raw - shift, "u8"),
                "u8",
            )
            shown, shift = binary("+", shown, step, "u8"), look.final - look.raw
    for look in found:
        if not look.same:
            shown = select(w.keep(f"is_{look.kind.name}", Value(_inside(look, raw), "bool", axes)), _shown(look, raw, axes, w), shown)
    return w.keep("content", shown)


def _shown(look: Look, raw: Value, axes: tuple[Axis, ...], w: Writer) -> Value:
    """Returns the number of a kind's look for each observer, from its painted values."""
    values = _values(look, raw, axes, w)
    place = _seen_cell(look, look.kind.name, values, axes)
    if look.labels:
        number = literal(look.labels[look.final_words[0].index(look.sights[0].labels[-1].name)], "u8")
        for label in reversed(look.sights[0].labels[:-1]):
            assert label.condition is not None
            shown = literal(look.labels[look.final_words[0].index(label.name)], "u8")
            number = select(lower(label.condition, place, w), shown, number)
        return number
    number: Value | None = None
    for sight, words in zip(look.sights, look.final_words, strict=True):
        one = _sight(sight, words, values, place, w)
        number = one if number is None else binary("+", binary("*", number, literal(len(words), "u8"), "u8"), one, "u8")
    assert number is not None
    return binary("+", number, literal(look.final, "u8"), "u8")


def _values(look: Look, raw: Value, axes: tuple[Axis, ...], w: Writer) -> dict[str, Value]:
    """Returns the painted fields of a kind, taken out of the numbers of looks; where another kind is they mean nothing."""
    values: dict[str, Value] = {}
    rest = f"({raw.text} - {look.raw})"
    for field, size in reversed(look.painted):
        text = f"{rest} % {size}" if field is not look.painted[0][0] else rest
        values[field.name] = w.keep(f"{look.kind.name}_{field.name}", Value(text, "u8", axes))
        rest = f"({rest} // {size})"
    return values


def _seen_cell(look: Look, name: str, values: dict[str, Value], axes: tuple[Axis, ...]) -> Frame:
    """Returns the scope of a condition about the observer and the cell that it sees."""
    cell = SeenCell(Value("0", "i32"), (look.kind.name,), None, values)
    return Frame(axes=axes, variables={"agent": AgentVar(iota(axes[0]), axes[0]), name: cell})


@dataclass(frozen=True)
class SeenCell(CellVar):
    """A cell of a window: only the fields that were painted are known of it."""

    values: dict[str, Value] | None = None


def _sight(sight: ir.Sight, words: tuple[str, ...], values: dict[str, Value], place: Frame, w: Writer) -> Value:
    if sight.labels:
        result = literal(words.index(sight.labels[-1].name), "u8")
        for label in reversed(sight.labels[:-1]):
            assert label.condition is not None
            result = select(_asked(label.condition, place, w), literal(words.index(label.name), "u8"), result)
            if result.text.startswith("jnp.where") and result.dtype != "u8":
                result = replace(result, dtype="u8")
        result = Value(f"{wrapped(result)}.astype(jnp.uint8)", "u8", result.axes) if not result.literal else result
    else:
        result = values[sight.field]
    if sight.hidden_when is not None:
        result = select(_asked(sight.hidden_when, place, w), literal(len(words) - 1, "u8"), result)
    return result


def _asked(test: ir.Expr, place: Frame, w: Writer) -> Value:
    """Returns what a label or `hide` asks; its place is that of what cannot be asked."""
    try:
        return lower(test, place, w)
    except NotSupported as refused:
        refused.origin = refused.origin or test.origin
        raise


def _agents(agent: Value, axes: tuple[Axis, ...], by_id: bool, w: Writer) -> list[Value]:
    """Returns the plane of agents, then one for each thing shown of the others."""
    game, window = w.module.game, w.module.game.window
    size = (window.ahead + 1 + window.behind, window.left + 1 + window.right, window.ahead, window.left)
    own = Table(own_cell(*size), f"own_cell{size}")
    myself = w.module.constant("myself", own, "which cell of its window is the observer's own")
    self_ = Value(f"{myself}[None]", "bool", axes)
    agent = w.keep("agent", agent)
    heading = next((s for s in game.sights if s.what == "heading"), None)
    mine = "state.heading.astype(jnp.uint8)[:, None]"
    somebody = binary("!=", agent, literal(0, "u8"), "bool")
    if not by_id:
        other = f"2 + (({agent.text} - 1 - {mine}) & 3)" if heading is not None else "jnp.uint8(2)"
        shown = f"jnp.where({somebody.text}, {other}, 0)"
        return [Value(f"jnp.where({self_.text}, 1, {shown}).astype(jnp.uint8)", "u8", axes)]
    who = w.keep("who", Value(f"jnp.maximum({agent.text}.astype(jnp.int32) - 1, 0)", "i32", axes))
    other_var = AgentVar(who)
    observer = AgentVar(iota(axes[0]), axes[0])
    place = Frame(axes=axes, variables={"agent": observer, "other": other_var})
    facing: Value = literal(2, "u8")
    if heading is not None:
        facing = Value(f"(2 + ((state.heading[{who.text}] - state.heading[:, None]) & 3)).astype(jnp.uint8)", "u8", axes)
        if heading.hidden_when is not None:
            facing = select(lower(heading.hidden_when, place, w), literal(6, "u8"), facing)
    first = f"jnp.where({self_.text}, 1, jnp.where({somebody.text}, {facing.text}, 0)).astype(jnp.uint8)"
    columns = [Value(first, "u8", axes)]
    theirs = w.keep("theirs", Value(f"({somebody.text}) & ~{self_.text}", "bool", axes))
    for sight in game.sights:
        if sight.what == "other":
            value = _field_sight(sight, other_var, place, w)
            if sight.labels or sight.type.kind == "word":
                value = binary("+", value, literal(1, "u8"), "u8")
            value = select(theirs, value, literal(0, "u8"))
            if sight.hidden_when is not None:
                value = select(lower(sight.hidden_when, place, w), literal(0, "u8"), value)
            columns.append(value)
    return columns


def _field_sight(sight: ir.Sight, who: AgentVar | None, place: Frame, w: Writer) -> Value:
    """Returns the value of a shown field as a byte."""
    if sight.labels:
        words = tuple(dict.fromkeys(x.name for x in sight.labels))
        return _sight(sight.model_copy(update={"hidden_when": None}), words, {}, place, w)
    fields = w.module.game.agents.fields if who is not None else w.module.game.fields
    declared = next(f for f in fields if f.name == sight.field)
    read = ir.FieldRead(type=declared.type, owner=None, place="agent" if who is not None else "world", name=sight.field)
    stored = state_reads.field(read, who, w)
    if sight.word is not None:
        key = declared.type.by[0].index(sight.word)
        stored = replace(stored, text=f"{wrapped(stored)}[{':, ' * len(stored.axes)}{key}]", levels=0)
    if stored.dtype == "u8":
        return stored
    bound = stored.text if state_reads.storage(declared, w) == "u8" else f"jnp.minimum({stored.text}, 255)"
    return Value(f"{wrapped(Value(bound, 'i32'))}.astype(jnp.uint8)", "u8", stored.axes)


def _marks(marks: list[Part], planes: dict[str, Value]) -> Value:
    """Returns the marks of a cell as bits, one a phase."""
    if len(marks) == 1:
        return planes[marks[0].name]
    if all(m.plane == marks[0].plane and m.shift == marks[0].shift + i for i, m in enumerate(marks)):
        text = f"(seen_{marks[0].plane} >> {marks[0].shift}) & {2 ** len(marks) - 1}"
        return replace(planes[marks[0].name], text=text)
    text = " | ".join(f"(({planes[m.name].text}) << {i})" for i, m in enumerate(marks))
    return replace(planes[marks[0].name], text=text)


def _somebody(planes: dict[str, Value], w: Writer) -> Value:
    """Returns where an agent stands, the observer too."""
    return w.keep("somebody", binary("!=", planes["agent"], literal(0, "u8"), "bool"))


def _without_hidden(marks: Value, planes: dict[str, Value], axes: tuple[Axis, ...], w: Writer) -> Value:
    """Returns the marks that are seen: none on the cells on which they are hidden."""
    found = {look.kind.name: look for look in looks(w.module.game) if look.present}
    raw = w.keep("raw", planes["content"]) if any(h.on == "cells" for h in w.module.game.hidden) else planes["content"]
    for hidden in w.module.game.hidden:
        if hidden.what == "marks" and hidden.on == "agents":
            marks = select(_somebody(planes, w), literal(0, "u8"), marks)
        for look in (found[kind] for kind in hidden.kinds if kind in found):
            w.origin = hidden.origin
            there = w.keep(f"on_{look.kind.name}", Value(_inside(look, raw), "bool", axes))
            if hidden.when is not None:
                place = _seen_cell(look, hidden.name, _values(look, raw, axes, w), axes)
                there = binary("&", there, lower(hidden.when, place, w), "bool")
            marks = select(there, literal(0, "u8"), marks)
    return marks


def _inside(look: Look, raw: Value) -> str:
    """Returns whether a number of looks is of a kind."""
    if look.raw_values == 1:
        return f"{raw.text} == {look.raw}"
    return f"({raw.text} >= {look.raw}) & ({raw.text} < {look.raw + look.raw_values})"


def _everyone(axes: tuple[Axis, ...], w: Writer) -> list[Value]:
    """Returns what is shown of every agent: for each such thing a plane an agent, in the order of their numbers, side by side."""
    columns = []
    both = (axes[0], w.axis("everyone", w.module.num_agents))
    observer, who = (AgentVar(iota(axis), axis) for axis in both)
    place = Frame(axes=both, variables={"agent": observer, "everyone": who})
    for sight in w.module.game.sights:
        if sight.what == "everyone":
            w.origin = sight.origin
            value = w.keep(f"everyone_{sight.field}", _field_sight(sight, who, place, w))
            columns.append(Value(f"{_full(value, (*both, axes[1]))}.reshape({axes[0].size}, -1)", "u8", axes))
    return columns


def _own(axes: tuple[Axis, ...], w: Writer) -> list[Value]:
    """Returns the planes of the observer's own fields and the world's."""
    columns = []
    observer = AgentVar(iota(axes[0]), axes[0])
    place = Frame(axes=axes[:1], variables={"agent": observer})
    for what in ("own", "world"):
        for sight in w.module.game.sights:
            if sight.what == what:
                w.origin = sight.origin
                value = _field_sight(sight, observer if what == "own" else None, place, w)
                if sight.hidden_when is not None:
                    value = select(lower(sight.hidden_when, place, w), literal(0, "u8"), value)
                columns.append(w.keep(f"shown_{sight.field}", value))
    return columns


__all__ = ["NotSupported", "observe", "parts_of", "to_words"]

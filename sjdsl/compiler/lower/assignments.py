"""Lowers `set` and `add`: by selection where the target is the axis itself, by scatter where its index is computed."""

from dataclasses import replace

import numpy as np

from sjdsl.compiler import ir
from sjdsl.compiler.ir.names import attribute_name
from sjdsl.compiler.lower import state_reads
from sjdsl.compiler.lower.axes import DTYPES, Axis, Value, aligned, as_dtype, binary, both, literal, reduce, select, union, wrapped
from sjdsl.compiler.lower.expressions import lower, owner, to_words
from sjdsl.compiler.lower.scope import AgentVar, CellVar, Frame, NotSupported, Writer


def split(target: ir.Expr) -> tuple[ir.FieldRead, tuple[ir.Expr, ...]]:
    """Returns the field a target names, and the keys into its row."""
    keys: list[ir.Expr] = []
    while isinstance(target, ir.At):
        keys.insert(0, target.key)
        target = target.row
    assert isinstance(target, ir.FieldRead)
    return target, tuple(keys)


def set_(s: ir.Set, frame: Frame, w: Writer) -> None:
    """Writes `set target = value`."""
    target, keys = split(s.target)
    value = stored_value(s.value, s.target.type, frame, w)
    for declared, place, frame_ in targets(target, frame, w):
        dtype = state_reads.storage(declared, w)
        write(declared, place, keys, target, as_dtype(value, dtype) if value.dtype != dtype else value, frame_, w)


def stored_value(e: ir.Expr, type_: ir.Type, frame: Frame, w: Writer) -> Value:
    """Returns a value as the field keeps it: words of its own set, agents as numbers, nobody as the empty set."""
    if type_.kind == "agents" and isinstance(e, ir.Nobody):
        return literal(0, w.module.set_dtype)
    value = lower(e, frame.always(), w)
    if type_.kind == "word":
        return to_words(value, e.type.words, type_.words)
    if type_.kind == "real":
        return as_dtype(value, "f32")
    return value


def targets(target: ir.FieldRead, frame: Frame, w: Writer) -> list[tuple[ir.VarField, AgentVar | CellVar | None, Frame]]:
    """Returns the fields a write reaches, each with whose it is: one, or one for each kind of a group that is on the map."""
    if target.owner is None:
        return [(w.module.field(target), None, frame)]
    who = owner(target.owner, frame, w)
    if isinstance(who, AgentVar) or len(who.kinds) == 1:
        return [(w.module.field(target), who, frame)]
    found: list[tuple[ir.VarField, AgentVar | CellVar | None, Frame]] = []
    layout = w.module.layout
    for kind in who.kinds:
        if not len(layout.cells((kind,))):
            continue  # not on this map: no cell that could be written
        table = layout.site_of((kind,))[layout.cells(who.kinds)]
        table = np.append(table, len(layout.cells((kind,)))).astype(np.int32)
        name = w.module.constant(
            f"{'_'.join(who.kinds)}_to_{kind}",
            table,
            f"number among {kind} of each cell of the group; past the end: none",
        )
        text = f"{name}[:-1]" if who.axis is not None else f"{name}[{who.site.text}]"
        axes = (who.axis,) if who.axis is not None else who.site.axes
        found.append((w.module.field(target, kind), CellVar(Value(text, "i32", axes), (kind,)), frame))
    return found


def write(
    declared: ir.VarField,
    who: AgentVar | CellVar | None,
    keys: tuple[ir.Expr, ...],
    target: ir.FieldRead,
    value: Value,
    frame: Frame,
    w: Writer,
) -> None:
    """Writes one field where the place's condition holds."""
    attribute = attribute_name(declared)
    levels = len(target.type.by)
    dtype = state_reads.storage(declared, w)
    key = _word_of(keys, target, frame, w)
    if who is None or who.axis is not None:
        axis = () if who is None else (who.axis,)
        over = tuple(a for a in frame.axes if a not in axis)
        mask = None if frame.mask is None else reduce("any", frame.mask, over)
        key = None if key is None else _of_the_one(key, over)
        before = Value(w.current(attribute), dtype, axis, levels)  # type: ignore[arg-type]
        w.assign(attribute, _entries(before, mask, key, target, _of_the_one(value, over)).text)
        return
    index = who.index if isinstance(who, AgentVar) else who.site
    size = w.module.num_agents if isinstance(who, AgentVar) else w.module.layout.num_cells(who.kinds)
    _scatter(attribute, index, size, key, value, levels, frame, w)


def _word_of(keys: tuple[ir.Expr, ...], target: ir.FieldRead, frame: Frame, w: Writer) -> Value | None:
    """Returns which entry of a row is written, a word of the row's own set; None for all of it."""
    return to_words(lower(keys[0], frame.always(), w), keys[0].type.words, target.type.by[0]) if keys else None


def _of_the_one(value: Value, over: tuple[Axis, ...]) -> Value:
    """Returns a value or key without the axes of the sentences inside the target's.

    It differs along them only if one instance at most reaches each target (else the write is refused): they are lanes of shapes
    with one lane.
    """
    gone = tuple(a for a in over if a in value.axes)
    if not gone:
        return value
    assert all(a.size == 1 for a in gone), gone
    kept = tuple(a for a in value.axes if a not in gone)
    index = ", ".join("0" if a in gone else ":" for a in value.axes)
    return replace(value, text=f"{wrapped(value)}[{index}]", axes=kept)


def _entries(before: Value, mask: Value | None, key: Value | None, target: ir.FieldRead, value: Value) -> Value:
    """Returns the field with the value in its place: the whole, or one entry of a row."""
    if mask is not None and mask.text == "False":
        return before
    if key is None:
        if mask is None:
            return _filled(before, value)
        if mask is not None and before.levels:
            mask = replace(mask, text=_with_levels(mask, before.axes, before.levels), axes=before.axes, levels=before.levels)
        return select(mask, value, before)
    lead = ":, " * len(before.axes)
    if key.literal:
        old = replace(before, text=f"{before.text}[{lead}{key.text}]", levels=0)
        new = select(mask, value, old)
        return replace(before, text=f"{before.text}.at[{lead}{key.text}].set({new.text})")
    words = len(target.type.by[0])
    chosen = f"{_for_each_word(key, before.axes)} == jnp.arange({words}, dtype=jnp.uint8)"
    if before.axes:
        chosen += f"[{', '.join(['None'] * len(before.axes))}, :]"
    hit = f"({chosen})" if mask is None else f"(({chosen}) & {_for_each_word(replace(mask, text=wrapped(mask)), before.axes)})"
    new = _for_each_word(value, before.axes)
    return replace(before, text=f"jnp.where({hit}, {new}, {before.text})")


def _for_each_word(value: Value, axes: tuple[Axis, ...]) -> str:
    """Returns the text with one more axis, for the words of a row; what has no axes is the same for all."""
    return f"{wrapped(replace(value, text=aligned(value, axes)))}[..., None]" if value.axes else value.text


def _with_levels(mask: Value, axes: tuple[Axis, ...], levels: int) -> str:
    if not mask.axes:
        return mask.text
    text = aligned(mask, axes)
    return f"{wrapped(replace(mask, text=text))}[{', '.join([':'] * len(axes) + ['None'] * levels)}]"


def _filled(before: Value, value: Value) -> Value:
    """Returns the field with the value everywhere."""
    if value.axes == before.axes and value.levels == before.levels and not value.literal:
        return value
    if not value.axes and not value.levels:
        return replace(before, text=f"jnp.full_like({before.text}, {value.text})")
    spread = aligned(value, before.axes)
    if value.levels < before.levels:
        spread = f"{wrapped(replace(value, text=spread))}[..., None]"
    return replace(before, text=f"jnp.broadcast_to({spread}, {before.text}.shape)")


def _scatter(
    attribute: str,
    index: Value,
    size: int,
    key: Value | None,
    value: Value,
    levels: int,
    frame: Frame,
    w: Writer,
) -> None:
    """Writes at computed places; instances that do not happen write past the end."""
    axes = union(index.axes, *(x.axes for x in (frame.mask, key, value) if x is not None))
    at = select(frame.mask, index, literal(size, "i32"))
    shape = ", ".join(str(a.size) for a in axes)
    at_text = aligned(at, axes) if at.axes else at.text
    if axes and at.axes != axes:
        at_text = f"jnp.broadcast_to({at_text}, ({shape},))"
    column = ""
    if key is not None:
        column = f", {aligned(key, axes)}"
    value_text = aligned(value, axes) if value.axes and value.axes != axes else value.text
    if levels and key is None and value.axes and not value.levels:
        value_text = f"{wrapped(replace(value, text=value_text))}[{', '.join([':'] * len(axes) + ['None'] * levels)}]"
    w.assign(attribute, f'{w.current(attribute)}.at[{at_text}{column}].set({value_text}, mode="drop")')


def add(s: ir.Add, frame: Frame, w: Writer) -> None:
    """Collects `add value to target`; the sums are applied at the end of the phase."""
    target, keys = split(s.target)
    for declared, who, place in targets(target, frame, w):
        if target.type.kind == "agents":
            _add_member(s, declared, who, keys, target, place, w)
            continue
        value = lower(s.value, place.always(), w)
        value = as_dtype(value, "f32" if target.type.kind == "real" else "i32")
        _add_number(declared, who, keys, target, value, place, w)


def _add_number(
    declared: ir.VarField,
    who: AgentVar | CellVar | None,
    keys: tuple[ir.Expr, ...],
    target: ir.FieldRead,
    value: Value,
    frame: Frame,
    w: Writer,
) -> None:
    attribute = attribute_name(declared)
    masked = _masked(value, frame)
    levels = len(target.type.by)
    if keys:
        key = to_words(lower(keys[0], frame.always(), w), keys[0].type.words, target.type.by[0])
        words = len(target.type.by[0])
        masked = _one_hot(masked, key, words)
    sums = w.added.setdefault(attribute, [])
    if who is None or who.axis is not None:
        axis = () if who is None else (who.axis,)
        total = reduce("sum", masked, tuple(a for a in frame.axes if a not in axis))
        sums.append(
            w.keep(
                f"{attribute}_added",
                replace(total, text=aligned(total, axis) if total.axes else total.text, axes=axis if total.axes else ()),
            )
        )  # type: ignore[arg-type]
        return
    index = who.index if isinstance(who, AgentVar) else who.site
    size = w.module.num_agents if isinstance(who, AgentVar) else w.module.layout.num_cells(who.kinds)
    axes = union(index.axes, masked.axes)
    rest = tuple(a for a in frame.axes if a not in axes)
    total = reduce("sum", masked, rest)
    at = aligned(index, axes)
    if index.axes != axes:
        at = f"jnp.broadcast_to({at}, ({', '.join(str(a.size) for a in axes)},))"
    dims = f"{size}" + "".join(f", {len(by)}" for by in target.type.by)
    zero = f"jnp.zeros(({dims},), {'jnp.float32' if total.dtype == 'f32' else 'jnp.int32'})"
    amount = total.text if not total.axes else (aligned(total, axes) if not total.levels else _row_aligned(total, axes))
    shape = (Axis(f"all of {attribute}", size, 0),)
    sums.append(w.keep(f"{attribute}_added", Value(f'{zero}.at[{at}].add({amount}, mode="drop")', total.dtype, shape, levels)))


def _row_aligned(value: Value, axes: tuple[Axis, ...]) -> str:
    if value.axes == axes:
        return value.text
    return f"{wrapped(value)}[{', '.join([':' if a in value.axes else 'None' for a in axes] + [':'] * value.levels)}]"


def _masked(value: Value, frame: Frame) -> Value:
    if frame.mask is None:
        return value
    mask = frame.mask
    if value.levels:
        axes = union(mask.axes, value.axes)
        text = (
            f"{wrapped(replace(mask, text=aligned(mask, axes)))}[{', '.join([':'] * len(axes) + ['None'] * value.levels)}]"
            if mask.axes
            else mask.text
        )
        row = _row_aligned(value, axes)
        return Value(f"jnp.where({text}, {row}, 0)", value.dtype, axes, value.levels)
    return select(mask, value, literal(0, value.dtype))


def _one_hot(value: Value, key: Value, words: int) -> Value:
    """Returns a row that has the value at the key's word and 0 elsewhere."""
    axes = union(value.axes, key.axes)
    lead = f"[{', '.join(['None'] * len(axes))}, :]" if axes else ""
    word, amount = (_for_each_word(x, axes) for x in (key, value))
    zero = "jnp.float32(0.0)" if value.dtype == "f32" else "jnp.int32(0)"
    return Value(f"jnp.where({word} == jnp.arange({words}, dtype=jnp.uint8){lead}, {amount}, {zero})", value.dtype, axes, 1)


def _add_member(
    s: ir.Add,
    declared: ir.VarField,
    who: AgentVar | CellVar | None,
    keys: tuple[ir.Expr, ...],
    target: ir.FieldRead,
    frame: Frame,
    w: Writer,
) -> None:
    """Adds agents to sets kept as bits: a table of who is added where, folded into bits."""
    attribute = attribute_name(declared)
    n = w.module.num_agents
    if n > 32:
        instead = "keep a field of each agent instead, of the words of who belongs to it and who does not"
        raise NotSupported(f"a set of agents in a game of {n} agents (at most 32)", s.origin, instead)
    member = lower(s.value, frame.always(), w)
    joining = frame.variables[s.value.name] if isinstance(s.value, ir.Member) else None
    dtype = DTYPES[w.module.set_dtype]
    if who is None:
        instead = "keep a field of each agent instead, such as `field in_club : { outside_it, inside_it } = outside_it`"
        raise NotSupported("adding to a set of agents that is a field of the world", s.origin, instead)
    index = who.index if isinstance(who, AgentVar) else who.site
    size = n if isinstance(who, AgentVar) else w.module.layout.num_cells(who.kinds)
    key = [to_words(lower(k, frame.always(), w), k.type.words, target.type.by[0]) for k in keys]
    axes = union(index.axes, member.axes, *(k.axes for k in key), () if frame.mask is None else frame.mask.axes)
    at = select(frame.mask, index, literal(size, "i32"))
    shape = ", ".join(str(a.size) for a in axes)
    spread = [x.text if x.axes == axes else f"jnp.broadcast_to({aligned(x, axes)}, ({shape},))" for x in (at, *key, member)]
    words = [str(len(target.type.by[0])) for _ in key]
    name = f"{attribute}_joined"
    itself = joining.axis if isinstance(joining, AgentVar) else None
    if itself in axes and all(a.size == 1 or a == itself for a in axes):  # the bit of an agent is added once at most
        own = aligned(Value(f"({dtype}(1) << jnp.arange({n}, dtype={dtype}))", w.module.set_dtype, (itself,)), axes)
        where = spread[0] if not key else ", ".join(spread[:-1])
        sets = f'jnp.zeros(({", ".join([str(size), *words])},), {dtype}).at[{where}].add({own}, mode="drop")'
    else:
        table = f'jnp.zeros(({", ".join([str(size), *words, str(n)])}), bool).at[{", ".join(spread)}].set(True, mode="drop")'
        sets = f"as_bits({w.keep(name, Value(table, 'bool')).text}, {dtype})"
    if target.type.by and not keys:  # to every entry of the row
        sets = f"({sets})[:, None]"
    w.joined.setdefault(attribute, []).append(w.keep(name, Value(sets, w.module.set_dtype)).text)


def finish(w: Writer) -> None:
    """Applies the sums of the phase, brings capped fields into their range, and joins sets."""
    for attribute, sums in w.added.items():
        declared = next(f for f in all_fields(w.module.game) if attribute_name(f) == attribute)
        dtype = state_reads.storage(declared, w)
        wide = "i32" if declared.type.kind == "int" else "f32"
        text = wrapped(as_dtype(Value(w.current(attribute), dtype), wide))
        for total in sums:
            text += f" + {wrapped(total)}"
        if declared.capped:
            text = f"jnp.clip({text}, {int(declared.type.low)}, {int(declared.type.high)})"
        w.assign(attribute, as_dtype(Value(text, wide), dtype).text)
    for attribute, sets in w.joined.items():
        w.assign(attribute, " | ".join([w.current(attribute), *sets]))


def all_fields(game: ir.Game) -> list[ir.VarField]:
    """Returns every field of a game in the order of State."""
    return [*(f for k in game.kinds for f in k.fields), *game.agents.fields, *game.fields]


__all__ = ["add", "all_fields", "binary", "both", "finish", "set_", "split", "write"]

"""Lowers the choosing quantifiers `pick`, `first` and `match`."""

from dataclasses import replace
from math import prod

import numpy as np

from sjdsl.compiler import ir
from sjdsl.compiler.lower import state_reads
from sjdsl.compiler.lower.axes import Axis, Value, aligned, as_dtype, binary, both, invert, literal, union, wrapped
from sjdsl.compiler.lower.domains import _has_inner_blocks, enter, is_empty, sites_in, sweep, whole_set
from sjdsl.compiler.lower.draws import words
from sjdsl.compiler.lower.expressions import lower
from sjdsl.compiler.lower.scope import AgentVar, CellVar, Frame, NotSupported, Writer, iota

MANY_SETS = 64  # from so many sets on it pays to draw words only if some set has several members


def _members(inner: Frame, outer: Frame) -> tuple[Axis, ...]:
    return tuple(a for a in inner.axes if a not in outer.axes)


def _mask_over(inner: Frame, axes: tuple[Axis, ...]) -> Value:
    """Returns the condition of a place with all the axes spelt out."""
    mask = inner.mask if inner.mask is not None else literal(True, "bool")
    if mask.axes == axes:
        return mask
    shape = ", ".join(str(a.size) for a in axes)
    return Value(f"jnp.broadcast_to({aligned(mask, axes)}, ({shape},))", "bool", axes)


def pick(s: ir.Pick, frame: Frame, w: Writer) -> tuple[Frame, Value]:
    """Returns the place inside a `pick`, and where there was no member at all."""
    if is_empty(s.domain, w):
        return frame.when(literal(False, "bool")), literal(True, "bool")
    inner = _candidates_of(s.domain, replace(frame, mask=None), w)
    new = _members(inner, frame)
    if not new:  # the member is determined: it is there or not
        there = inner.mask if inner.mask is not None else literal(True, "bool")
        number = as_dtype(lower(s.number, frame.always(), w), "i32")
        wanted = both(there, binary(">", number, literal(0, "i32"), "bool"))
        return inner.when(frame.mask).when(wanted), invert(there)
    axis = new[-1]
    member_var = inner.variables[s.domain.var.name]
    near = isinstance(s.domain.place, ir.Near) and isinstance(member_var, CellVar)
    total = axis.size if near else state_reads.member_total(member_var, w)
    number = as_dtype(lower(s.number, frame.always(), w), "i32")
    one = number.literal and int(number.text) == 1
    turns = w.axis("turn", min(s.most, total))
    word = words(s.stream, frame, (turns, turns.size))
    members = whole_set(s.domain, frame, w) if one else None
    around = (members or inner.mask or literal(True, "bool")).axes
    outer_axes = union(word.axes[:-1], tuple(a for a in around if a != axis))
    axes = (*outer_axes, axis)
    if one:
        lead = ":, " * (len(word.axes) - 1)
        single = Value(f"{word.text}[{lead}0]", "u32", word.axes[:-1])
        kernel, source = ("pick_of_set", aligned(members, outer_axes)) if members else ("pick", _mask_over(inner, axes).text)
        drawn = _spread(single, outer_axes)
        many = members is not None and members.axes == outer_axes and prod(a.size for a in outer_axes) >= MANY_SETS
        best = Value(w.names.fresh(s.domain.var.name), "u8" if many and single.text.startswith("words(") else "i32", outer_axes)
        found = Value(w.names.fresh("found"), "bool", outer_axes)
        if best.dtype == "u8":  # the words depend on the key alone: most steps need none of them
            source = source if frame.mask is None else f"jnp.where({aligned(frame.mask, outer_axes)}, {source}, 0)"
            w.line(f"{best.text}, {found.text} = pick_of_sets({source}, key, lambda key: {drawn})")
            best = w.keep(s.domain.var.name, Value(f"{best.text}.astype(jnp.int32)", "i32", outer_axes))
        else:
            w.line(f"{best.text}, {found.text} = {kernel}({source}, {drawn})")
        chosen = _chosen_variable(member_var, axis, best)
        variables = {**frame.variables, s.domain.var.name: chosen}
        variables |= _under(s.domain, chosen, w)
        digit = (best, total)
        place = replace(frame, digits=(*frame.digits, digit), variables=variables)
        return place.when(found), invert(found)
    mask = w.keep("member", _mask_over(inner, axes))
    found = w.keep("found", Value(f"jnp.any({mask.text}, axis={len(axes) - 1})", "bool", outer_axes))
    text = f"choose({mask.text}, {_spread(word, (*outer_axes, turns))}, {_number_array(number, outer_axes)})"
    taken = w.keep("taken", Value(text, "bool", axes))
    return replace(inner, mask=both(frame.mask, taken)), invert(found)


def _candidates_of(d: ir.Domain, frame: Frame, w: Writer) -> Frame:
    """Returns the place inside the domain of a `pick`, one axis for all that may be members; of agents in braces, in the order of ids."""
    if not isinstance(d.place, ir.Among):
        return enter(d, frame, w)
    inner = enter(d.model_copy(update={"place": None}), frame, w)
    one = state_reads.member_number(inner.variables[d.var.name])
    named = literal(False, "bool")
    for member in d.place.members:
        same = binary("==", one, state_reads.member_number(frame.variables[member.name]), "bool")
        named = same if named.literal else binary("|", named, same, "bool")
    return inner.when(named)


def _spread(word: Value, axes: tuple[Axis, ...]) -> str:
    """Returns words over exactly these axes."""
    if word.axes == axes:
        return word.text
    shape = ", ".join(str(a.size) for a in axes)
    return f"jnp.broadcast_to({aligned(word, axes)}, ({shape},))"


def _number_array(number: Value, axes: tuple[Axis, ...]) -> str:
    shape = ", ".join(str(a.size) for a in axes)
    text = f"jnp.int32({number.text})" if number.literal else (aligned(number, axes) if number.axes else number.text)
    return f"jnp.broadcast_to({text}, ({shape},))" if axes else text


def _chosen_variable(member: AgentVar | CellVar, axis: Axis, best: Value) -> AgentVar | CellVar:
    """Returns the variable of the one picked: its number, or the number at its place in a shape."""
    if isinstance(member, AgentVar):
        return AgentVar(best)
    if member.axis is not None:
        return CellVar(best, member.kinds)
    return CellVar(_take(member.site, axis, best), member.kinds)


def _take(values: Value, axis: Axis, best: Value) -> Value:
    """Returns the entry of `values` along an axis that `best` names."""
    if values.axes == (axis,):
        return Value(f"{wrapped(values)}[{best.text}]", values.dtype, best.axes)
    everything = union(values.axes, best.axes)  # what is picked may differ along more axes than what it is picked from
    at = aligned(best, everything) if best.axes else f"jnp.full(({', '.join(['1'] * len(everything))},), {best.text})"
    taken = f"jnp.take_along_axis({aligned(values, everything)}, {at}, axis={everything.index(axis)})"
    entry = "..., 0" if everything[-1] == axis else ", ".join("0" if a == axis else ":" for a in everything)
    return Value(f"{taken}[{entry}]", values.dtype, tuple(a for a in everything if a != axis))


def _under(d: ir.Domain, agent: AgentVar | CellVar, w: Writer) -> dict[str, AgentVar | CellVar]:
    if d.on is None or not isinstance(agent, AgentVar):
        return {}
    site, _ = state_reads.site_under(agent, d.on.kinds, w)
    return {d.on.name: CellVar(site, d.on.kinds)}


def first(s: ir.First, frame: Frame, w: Writer) -> tuple[Frame, Frame]:
    """Returns the place inside a `first` (one more axis: the lanes), and the place of its `otherwise`."""
    if is_empty(s.domain, w):
        lanes = _lanes(s.domain, w)
        return frame.when(literal(False, "bool")), _in_lanes(frame, lanes)
    inner, lanes, found, shape_axis = _nearest(s.domain, frame, w)
    hit = inner.when(frame.mask).when(found)
    assert shape_axis.size >= lanes.size
    return hit, _in_lanes(frame, lanes).when(invert(found))


def _lanes(d: ir.Domain, w: Writer) -> Axis:
    assert isinstance(d.place, ir.Near)
    return w.axis("lane", len(w.module.shape(d.place.shape).lanes))


def _in_lanes(frame: Frame, lanes: Axis) -> Frame:
    return replace(frame, axes=(*frame.axes, lanes), digits=(*frame.digits, (iota(lanes), lanes.size)))


def _nearest(d: ir.Domain, frame: Frame, w: Writer) -> tuple[Frame, Axis, Value, Axis]:
    """Returns the place of the nearest member in each lane (unmasked), the lanes' axis, and where there is one."""
    assert isinstance(d.place, ir.Near)
    shape = w.module.shape(d.place.shape)
    candidate, ok, axis = _candidates(d, frame, w)
    variables: dict[str, AgentVar | CellVar] = {**frame.variables, d.var.name: candidate}
    place = Frame((*frame.axes, axis), None, frame.digits, {**variables, **_under(d, candidate, w)}, frame.locals)
    if d.on is not None:
        agent = variables[d.var.name]
        assert isinstance(agent, AgentVar)
        ok = both(ok, state_reads.site_under(agent, d.on.kinds, w)[1]) or ok
    if d.where is not None:
        ok = both(ok, lower(d.where, place, w)) or ok
    rest = union(tuple(a for a in ok.axes if a != axis), tuple(a for a in _index(candidate).axes if a != axis))
    axes = (*rest, axis)
    ok = w.keep("ok", _mask_over(Frame(mask=ok), axes))
    lanes = _lanes(d, w)
    longest = max(map(len, shape.lanes))
    table = np.full((lanes.size, longest), axis.size, np.int32)
    number = 0
    for i, lane in enumerate(shape.lanes):
        table[i, : len(lane)] = range(number, number + len(lane))
        number += len(lane)
    name = w.module.constant(
        "lanes_of_" + "".join(c if c.isalnum() else "_" for c in shape.name).strip("_"),
        table,
        f"cells of each lane of {shape.name}, nearest first",
    )
    lead = ":, " * len(rest)
    padded = f"jnp.concatenate([{ok.text}, jnp.zeros_like({ok.text}[{lead}:1])], axis={len(rest)})"
    in_lane = w.keep("in_lane", Value(f"{padded}[{lead}{name}]", "bool"))
    at = w.keep("nearest", Value(f"jnp.argmax({in_lane.text}, axis=-1)", "i32"))
    found = w.keep("found", Value(f"jnp.any({in_lane.text}, axis=-1)", "bool", (*rest, lanes)))
    index = w.keep("place", Value(f"{name}[jnp.arange({lanes.size}){_lead(rest)}, {at.text}]", "i32", (*rest, lanes)))
    values = _index(candidate)
    whole = _mask_like(values, axes)
    chosen = w.keep(
        d.var.name,
        Value(
            f"jnp.take_along_axis({whole}, jnp.minimum({index.text}, {axis.size - 1}), axis={len(rest)})",
            "i32",
            (*rest, lanes),
        ),
    )
    variable = AgentVar(chosen) if isinstance(candidate, AgentVar) else CellVar(chosen, candidate.kinds)
    inner = replace(
        _in_lanes(frame, lanes),
        mask=None,
        variables={**frame.variables, d.var.name: variable, **_under(d, variable, w)},
    )
    return inner, lanes, found, axis


def _lead(rest: tuple[Axis, ...]) -> str:
    return f"[{', '.join(['None'] * len(rest))}, :]" if rest else ""


def _index(variable: AgentVar | CellVar) -> Value:
    return variable.index if isinstance(variable, AgentVar) else variable.site


def _mask_like(values: Value, axes: tuple[Axis, ...]) -> str:
    shape = ", ".join(str(a.size) for a in axes)
    return values.text if values.axes == axes else f"jnp.broadcast_to({aligned(values, axes)}, ({shape},))"


def _candidates(d: ir.Domain, frame: Frame, w: Writer) -> tuple[AgentVar | CellVar, Value, Axis]:
    """Returns who is on each cell of the shape, whether somebody is, and the shape's axis."""
    assert isinstance(d.place, ir.Near)
    if d.var.who == "cell":
        site, axis, ok = sites_in(d.place, d.var.kinds, frame, w, d.var.name)
        return CellVar(site, d.var.kinds), ok, axis
    swept = sweep(d.place, frame, w)
    cells = swept.cells
    here = f"{wrapped(cells)}[..., None] == state.position[{', '.join(['None'] * len(cells.axes))}, :]"
    standing = w.keep("standing", Value(here, "bool"))
    who = w.keep(d.var.name, Value(f"jnp.argmax({standing.text}, axis=-1).astype(jnp.int32)", "i32", cells.axes))
    anybody = w.keep("anybody", Value(f"jnp.any({standing.text}, axis=-1)", "bool", cells.axes))
    shape = w.module.shape(d.place.shape)
    ok = both(anybody, swept.ok if _has_inner_blocks(shape, w) else None)
    assert ok is not None
    return AgentVar(who), ok, swept.axis


def match_(s: ir.Match, frame: Frame, w: Writer) -> Frame:
    """Returns the place inside a `match`: the left side's axis, those without a partner masked out."""
    if frame.axes or frame.digits:  # a `pick 1` around it gives no axis, yet its pairs are others
        instead = "write the `match` outside, and what is around it as conditions in its `where`"
        raise NotSupported("`match` inside `each`, `pick`, `first` or another `match`", s.origin, instead)
    left = enter(s.left, replace(frame, mask=None), w)
    if not left.axes:
        instead = "one agent has no rivals for it: write `each` for the left side, and `pick 1` inside for the right"
        raise NotSupported("`match` of one certain agent", s.origin, instead)
    partner, size = _partners(s, left, w)
    partner = w.keep(s.right.var.name, partner)
    matched = binary("<", partner, literal(size, "i32"), "bool")
    if s.right.var.who == "agent":
        right: AgentVar | CellVar = AgentVar(partner)
    else:
        right = CellVar(partner, s.right.var.kinds)
    variables = {**left.variables, s.right.var.name: right, **_under(s.right, right, w)}
    inner = replace(left, variables=variables, mask=None)
    return inner.when(frame.mask).when(w.keep("matched", matched))


def _partners(s: ir.Match, left: Frame, w: Writer) -> tuple[Value, int]:
    """Returns the partner of each left member, and how many right members there are: the partner of those who have none."""
    right, rows = s.right, left.axes[-1]
    alike = (s.left.var.who, s.left.var.kinds) == (right.var.who, right.var.kinds)
    if not alike and set(s.left.var.kinds) & set(right.var.kinds):
        raise NotSupported("a `match` of two groups that have cells in common", s.origin, "match a group with itself, or with other kinds")
    size = w.module.num_agents if right.var.who == "agent" else w.module.layout.num_cells(right.var.kinds)
    if s.first:
        inner, lanes, found, _ = _nearest(right, left.always(), w)
        mask = both(left.mask, found)
        return _among_reached(s, _index(inner.variables[right.var.name]), mask, (rows, lanes), size, alike, w), size
    inner = enter(right, left, w)
    cols = inner.axes[-1]
    variable = inner.variables[right.var.name]
    if cols == rows:
        instead = "write `each` for both sides, one inside the other"
        raise NotSupported("a `match` whose right side is one certain agent for each left one", s.origin, instead)
    if variable.axis is None:
        return _among_reached(s, _index(variable), inner.mask, (rows, cols), size, alike, w), size
    assert size == cols.size
    mask = _mask_over(inner, (rows, cols)).text
    if alike:
        mask = f"({mask}) & ~jnp.eye({size}, dtype=bool)"
    drawn = f"words(key, 0x{s.stream:08x}, {rows.size}, {cols.size})"
    ranks = w.keep("order", Value(f"ranks({drawn}, {mask})", "u32", (rows, cols)))
    return Value(f"pair({ranks.text}, alike={alike})", "i32", (rows,)), size


def _among_reached(s: ir.Match, index: Value, mask: Value | None, axes: tuple[Axis, Axis], size: int, alike: bool, w: Writer) -> Value:
    """Returns partners among the few members that each left one reaches: a word for each of them, not for all pairs there are."""
    rows = axes[0]
    reached = w.keep("reached", Value(_mask_like(index, axes), "i32", axes))
    happens = wrapped(Value(_mask_like(literal(True, "bool") if mask is None else mask, axes), "bool"))
    mine = f"jnp.arange({rows.size}, dtype=jnp.int32)[:, None]"
    if alike:
        happens = f"{happens} & ({reached.text} != {mine})"
    drawn = f"words_at(key, 0x{s.stream:08x}, ({mine} * {size} + {reached.text}).astype(jnp.uint32))"
    ranks = w.keep("order", Value(f"ranks({drawn}, {happens})", "u32", axes))
    return Value(f"pair_reached({reached.text}, {ranks.text}, {size}, alike={alike})", "i32", (rows,))

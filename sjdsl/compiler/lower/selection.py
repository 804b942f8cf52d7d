"""Lowers quantifiers that choose members: `pick` at random, `first` along lanes of a shape."""

from dataclasses import replace
from functools import reduce
from math import prod
from operator import or_

from sjdsl.compiler import ir
from sjdsl.compiler.lower import state_reads
from sjdsl.compiler.lower.axes import (
    FALSE,
    TRUE,
    Axes,
    Axis,
    Value,
    aligned,
    as_dtype,
    axes_of,
    broadcast,
    called,
    iota,
    literal,
    looked_up,
    spread,
    union,
    without,
)
from sjdsl.compiler.lower.domains import (
    enter,
    has_inner_blocks,
    is_empty,
    number_in,
    sites_in,
    stand_on,
    sweep,
    whole_set,
)
from sjdsl.compiler.lower.draws import KEY, first_limit, need_no_state, random_bits
from sjdsl.compiler.lower.scope import (
    AgentVar,
    CellVar,
    IterationScope,
    SetOfOne,
    Variable,
    numbered,
)
from sjdsl.compiler.lower.writer import Writer
from sjdsl.compiler.program.expressions import (
    ALL,
    Call,
    Expression,
    Lambda,
    Literal,
    Where,
    call,
    reduction,
    scalar,
)

MANY_SETS = 64  # from so many sets on, bits are drawn only if some set has several members


def pick(
    s: ir.Pick, scope: IterationScope, w: Writer
) -> tuple[IterationScope, Value, tuple[ir.Stmt, ...]]:
    """Returns the scope inside a `pick`, where there was no member, and the block to write.

    The block of a lone `chance` may be written instead, as a part of the pick.
    """
    if is_empty(s.domain, w):
        return scope.when(FALSE), TRUE, s.body
    inner = _candidates_of(s.domain, scope.always(), w)
    number = as_dtype(w.value(s.number, scope), "i32")
    if inner.axes == scope.axes:  # the member is determined: it is there or not
        there = inner.mask
        return inner.when(scope.mask).when(there & (number > 0)), ~there, s.body
    member = inner.variables[s.domain.var.name]
    total = w.module.extent(member.entity_type)
    if isinstance(member, CellVar) and isinstance(s.domain.restriction, ir.Near):
        total = inner.axes[-1].extent
    if number == literal(1, "i32"):
        return *_pick_one(s, scope, inner, total, w), s.body
    return _pick_several(s, scope, inner, number, total, w)


def _pick_several(
    s: ir.Pick,
    scope: IterationScope,
    inner: IterationScope,
    number: Value,
    total: Literal,
    w: Writer,
) -> tuple[IterationScope, Value, tuple[ir.Stmt, ...]]:
    """Returns what `pick` does. total: how many candidates there are."""
    axis = inner.axes[-1]
    turns = w.axis("turn", min(s.most, total.size))
    bits = random_bits(s.stream, scope, w, turns)
    outer = union(bits.axes[:-1], without(inner.mask.axes, (axis,)))
    mask = w.keep("member", broadcast(inner.mask, (*outer, axis)))
    exists = w.keep_node("found", reduction("any", mask.node, (len(outer),)), "bool")
    nobody = ~Value(exists, "bool", outer)
    if not turns.size:
        return inner.when(FALSE), nobody, s.body
    if number.literal:
        number = replace(number, node=scalar(number.node, "i32"))
    arguments = [mask.node, spread(bits, (*outer, turns)), spread(number, outer)]
    chosen = call("choose", *arguments)
    body = s.body
    match s.body:
        case (ir.Chance(branches=(ir.Branch() as branch,), otherwise=()) as chance,) if (
            inner.digits == ((iota(axis), axis.extent),)
        ):
            w.origin = chance.origin
            limit = first_limit(branch.test, inner, w)
            if not limit.axes:  # the same for all members
                stream = w.stream(chance.stream)
                chosen = call("choose", *arguments, KEY, stream, limit.node)
                body = branch.body
    w.origin = s.origin
    taken = w.keep("taken", Value(chosen, "bool", mask.axes))
    return replace(inner, mask=scope.mask & taken), nobody, body


def _pick_one(
    s: ir.Pick, scope: IterationScope, inner: IterationScope, total: Literal, w: Writer
) -> tuple[IterationScope, Value]:
    """Returns what `pick 1` does: the scope with the member's number, and where there is none."""
    axis = inner.axes[-1]
    name = s.domain.var.name
    member = inner.variables[name]
    # The bits have no axis for the one turn: on a GPU, XLA would store them before it drops it.
    bits = random_bits(s.stream, scope, w)
    members = whole_set(s.domain, scope, w)
    around = inner.mask if members is None else members
    axes = union(bits.axes, without(around.axes, (axis,)))
    drawn = spread(bits, axes)
    if members is not None and _are_many_sets(members, axes) and need_no_state(scope.digits):
        chosen, exists = _pick_of_sets(members, drawn, scope, name, w)
        picked = chosen.number
    else:
        if members is None:
            kernel = "pick"
            source = spread(inner.mask, (*axes, axis))
        else:
            kernel = "pick_of_large_set" if members.levels else "pick_of_set"
            source = aligned(members, axes)
        who, has_member = w.keep_parts((name, "found"), call(kernel, source, drawn))
        picked = Value(who, "i32", axes)
        exists = Value(has_member, "bool", axes)
        number = picked
        if member.axis is None:  # it is a cell's place in a shape
            number = _take(member.number, axis, picked)
            if isinstance(number.node, Call):
                number = w.keep(name, number)
        chosen = numbered(s.domain.var, number)
    place = bound(s.domain, chosen, scope, w)
    place = replace(place, digits=(*scope.digits, (picked, total)))
    return place.when(exists), ~exists


def _are_many_sets(members: Value, axes: Axes) -> bool:
    """Returns whether there are so many small sets that most steps need no random bits."""
    is_many = prod(a.size for a in axes) >= MANY_SETS
    return is_many and members.axes == axes and not members.levels


def _pick_of_sets(
    members: Value, drawn: Expression, scope: IterationScope, name: str, w: Writer
) -> tuple[Variable, Value]:
    """Returns an agent of each set, and where there is one.

    drawn: computes random bits, which is done only if some set has several members.
    """
    has_members = members.ne(0).node
    # A mask takes no member from any set if it holds for all sets, or for those with members.
    takes_none = (has_members, w.known.get((has_members, "bool")))
    source = members.node
    if scope.mask != TRUE and scope.mask.node not in takes_none:
        source = Where(aligned(scope.mask, members.axes), source, Literal(0))
    alone = call("pick_of_sets", source, KEY, Lambda(("key",), drawn))
    picked = w.keep("picked", replace(members, node=alone))
    exists = w.keep("found", picked.ne(0))
    index = w.keep(name, called("member_of", picked, dtype="i32"))
    return AgentVar(index, alone=SetOfOne(picked, scope.mask & exists)), exists


def _candidates_of(d: ir.Domain, scope: IterationScope, w: Writer) -> IterationScope:
    """Returns the scope inside the domain of a `pick`, with one axis for all candidates.

    Agents in braces are in the order of their numbers, not as written.
    """
    if not isinstance(d.restriction, ir.Among):
        return enter(d, scope, w)
    inner = enter(d.model_copy(update={"restriction": None}), scope, w)
    candidate = inner.variables[d.var.name].number
    numbers = [number_in(d, scope.variables[member.name], w) for member in d.restriction.members]
    return inner.when(reduce(or_, [candidate.eq(number) for number in numbers]))


def _take(values: Value, axis: Axis, best: Value) -> Value:
    """Returns the entry of `values` along an axis that `best` names."""
    dtype = values.dtype
    if values.axes == (axis,):
        return looked_up(values.node, best, dtype)
    is_row_each = values.axes == (*best.axes, axis) and len(best.axes) == 1
    if is_row_each and best.axes[0].size >= state_reads.MANY:
        return Value(call("entries_at", values.node, best.node), dtype, best.axes)
    # What is picked may differ along more axes than what it is picked from.
    axes = axes_of(values, best)
    if best.axes:
        at = aligned(best, axes)
    else:
        at = call("jnp.full", (1,) * len(axes), best.node)
    entry: Expression = call(
        "jnp.take_along_axis", aligned(values, axes), at, axis=axes.index(axis)
    )
    if axes[-1] == axis:
        entry = entry[..., 0]
    else:
        entry = entry[tuple(0 if a == axis else ALL for a in axes)]
    return Value(entry, dtype, without(axes, (axis,)))


def bound(d: ir.Domain, member: Variable, scope: IterationScope, w: Writer) -> IterationScope:
    """Returns the scope with a member of a domain, and the cell under it if the domain binds it."""
    scope = scope.binding(d.var.name, member)
    if d.on is None or not isinstance(member, AgentVar):
        return scope
    site, _ = state_reads.site_under(member, d.on.kinds, w)
    return scope.binding(d.on.name, CellVar(site, d.on.kinds))


def nearest(d: ir.Domain, scope: IterationScope, w: Writer) -> tuple[IterationScope, Value]:
    """Returns the scope of the nearest member in each lane, and in which lanes there is one.

    The scope has one more axis, of the lanes, and no mask.
    """
    assert isinstance(d.restriction, ir.Near)
    shape = w.module.shape(d.restriction.shape)
    candidate, eligible = _candidates(d, scope, w)
    axis = candidate.number.axes[-1]
    place = replace(scope, axes=(*scope.axes, axis), mask=TRUE)
    place = bound(d, candidate, place, w)
    if d.on is not None:
        assert isinstance(candidate, AgentVar)
        _, is_on = state_reads.site_under(candidate, d.on.kinds, w)
        eligible = eligible & is_on
    if d.where is not None:
        eligible = eligible & w.value(d.where, place)
    outer = without(axes_of(eligible, candidate.number), (axis,))
    axes = (*outer, axis)
    eligible = w.keep("eligible", broadcast(eligible, axes))
    numbers = spread(candidate.number, axes)
    lanes = w.axis("lane", len(shape.lanes))
    lengths = tuple(map(len, shape.lanes))
    if max(lengths) == 1:  # every cell is a lane
        number = w.keep_node(d.var.name, numbers, "i32")
        exists = eligible.node
    else:
        pair = call("nearest_in_lanes", eligible.node, numbers, lengths)
        number, exists = w.keep_parts((d.var.name, "found"), pair)
    variable = numbered(d.var, Value(number, "i32", (*outer, lanes)))
    digits = (*scope.digits, (iota(lanes), lanes.extent))
    inner = replace(scope, axes=(*scope.axes, lanes), digits=digits, mask=TRUE)
    return bound(d, variable, inner, w), Value(exists, "bool", (*outer, lanes))


def _candidates(d: ir.Domain, scope: IterationScope, w: Writer) -> tuple[Variable, Value]:
    """Returns who is on each cell of the shape, along its axis, and whether somebody is."""
    assert isinstance(d.restriction, ir.Near)
    if d.var.entity_type.what == "cell":
        site, exists = sites_in(d.restriction, d.var.kinds, scope, w, d.var.name)
        return CellVar(site, d.var.kinds), exists
    swept = sweep(d.restriction, scope, w)
    on_cells = stand_on(swept.cells, state_reads.positions(w, d.var.entity_type))
    standing = w.keep_node("standing", on_cells, "bool")
    axes = swept.cells.axes
    who = w.keep(d.var.name, Value(reduction("argmax", standing, (-1,)), "i32", axes))
    anybody = w.keep("anybody", Value(reduction("any", standing, (-1,)), "bool", axes))
    if has_inner_blocks(w.module.shape(d.restriction.shape), w):
        anybody = anybody & swept.is_reached
    return AgentVar(who, entity_type=d.var.entity_type), anybody

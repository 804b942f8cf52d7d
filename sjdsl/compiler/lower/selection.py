"""Lowers quantifiers that choose members: `pick` at random, `first` along lanes of a shape.

    pick 1 water where water.state is clean { ... }  water, found = pick(is_clean, random_bits(...))

A chosen member is a computed number, so `pick 1` adds no axis; `pick n` has the axis of the
candidates, with a mask of those that are chosen; `first` has an axis of the lanes.
"""

from dataclasses import replace

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
    size_of,
    spread,
    union,
    without,
)
from sjdsl.compiler.lower.domains import (
    enter,
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
)

MANY_SETS = 64  # from so many sets on, random bits are drawn only if some set has several members


def pick(
    s: ir.Pick, scope: IterationScope, w: Writer
) -> tuple[IterationScope, Value, tuple[ir.Stmt, ...]]:
    """Lowers `pick n DOMAIN { body }`.

    Returns:
      the scope inside, where there was no candidate, and the statements to write inside: the body,
      or that of a `chance` which is all of the body, if the `chance` has become part of the pick.
    """
    if is_empty(s.domain, w):
        return scope.when(FALSE), TRUE, s.body
    inner = _candidates_of(s.domain, scope.always(), w)
    number = as_dtype(w.value(s.number, scope), "i32")
    if inner.axes == scope.axes:  # one certain candidate, which is a member or not
        is_member = inner.mask
        picked = inner.when(scope.mask).when(is_member & (number > 0))
        return picked, ~is_member, s.body
    candidate = inner.variables[s.domain.var.name]
    num_candidates = w.module.extent(candidate.entity_type)
    if isinstance(candidate, CellVar) and isinstance(s.domain.restriction, ir.Near):
        num_candidates = inner.axes[-1].extent
    if number == literal(1, "i32"):
        return *_pick_one(s, scope, inner, num_candidates, w), s.body
    return _pick_several(s, scope, inner, number, num_candidates, w)


def _pick_several(
    s: ir.Pick,
    scope: IterationScope,
    inner: IterationScope,
    number: Value,
    num_candidates: Literal,
    w: Writer,
) -> tuple[IterationScope, Value, tuple[ir.Stmt, ...]]:
    """Returns what `pick` does, for any number of members.

    inner: the scope of the candidates. number: how many are picked.
    """
    axis = inner.axes[-1]
    turns = w.axis("turn", min(s.most, num_candidates.size))
    bits = random_bits(s.stream, scope, w, turns)
    outer = union(bits.axes[:-1], without(inner.mask.axes, (axis,)))
    mask = w.keep("member", broadcast(inner.mask, (*outer, axis)))
    exists = w.keep_node("found", reduction("any", mask.node, (len(outer),)), "bool")
    nobody = ~Value(exists, "bool", outer)
    if not turns.size:
        return inner.when(FALSE), nobody, s.body
    arguments = [mask.node, spread(bits, (*outer, turns)), spread(number.array, outer)]
    chosen = call("choose", *arguments)
    body = s.body
    # `pick n D { chance p { ... } }`: the kernel also draws the chances, of chosen members only.
    draws_by_member = inner.digits == ((iota(axis), axis.extent),)
    match s.body:
        case (ir.Chance(branches=(branch,), otherwise=()) as chance,) if draws_by_member:
            w.origin = chance.origin
            limit = first_limit(branch.test, inner, w)
            if not limit.axes:  # the same for all members
                stream = w.stream(chance.stream)
                chosen = call("choose", *arguments, KEY, stream, limit.node)
                body = branch.body
    w.origin = s.origin
    is_chosen = w.keep("taken", Value(chosen, "bool", mask.axes))
    return replace(inner, mask=scope.mask & is_chosen), nobody, body


def _pick_one(
    s: ir.Pick, scope: IterationScope, inner: IterationScope, num_candidates: Literal, w: Writer
) -> tuple[IterationScope, Value]:
    """Returns the scope inside a `pick 1`, and where there was no candidate.

    inner: the scope of the candidates.
    """
    axis = inner.axes[-1]
    name = s.domain.var.name
    candidate = inner.variables[name]
    # The bits have no axis for the one turn: on a GPU, XLA would store them before it drops it.
    bits = random_bits(s.stream, scope, w)
    sets = whole_set(s.domain, scope, w)
    candidates = inner.mask if sets is None else sets
    axes = union(bits.axes, without(candidates.axes, (axis,)))
    drawn = spread(bits, axes)
    if sets is not None and _are_many_sets(sets, axes) and need_no_state(scope.digits):
        member, exists = _pick_of_sets(sets, drawn, scope, name, w)
        place = member.number
    else:
        if sets is None:
            kernel = "pick"
            source = spread(inner.mask, (*axes, axis))
        else:
            kernel = "pick_of_large_set" if sets.row_dims else "pick_of_set"
            source = aligned(sets, axes)
        picked, has_member = w.keep_parts((name, "found"), call(kernel, source, drawn))
        place = Value(picked, "i32", axes)  # among the candidates
        exists = Value(has_member, "bool", axes)
        number = place
        if candidate.axis is None:  # candidates are not in the order of their numbers
            number = _entry_at(candidate.number, axis, place)
            if isinstance(number.node, Call):
                number = w.keep(name, number)
        member = numbered(s.domain.var, number)
    picked_scope = bound(s.domain, member, scope, w)
    picked_scope = replace(picked_scope, digits=(*scope.digits, (place, num_candidates)))
    return picked_scope.when(exists), ~exists


def _are_many_sets(members: Value, axes: Axes) -> bool:
    """Returns whether there are so many small sets that most steps need no random bits."""
    is_many = size_of(axes) >= MANY_SETS
    return is_many and members.axes == axes and not members.row_dims


def _pick_of_sets(
    members: Value, drawn: Expression, scope: IterationScope, name: str, w: Writer
) -> tuple[Variable, Value]:
    """Returns a random member of each set of agents, and which sets have one.

    drawn: the expression of the random bits, which the kernel computes only if some set has several
      members.
    """
    has_members = members.ne(0).node
    # A mask that holds for all sets with members takes no member from any set.
    masks_without_effect = (TRUE.node, has_members, w.known.get((has_members, "bool")))
    source = members.node
    if scope.mask.node not in masks_without_effect:
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
    is_named = FALSE
    for member in d.restriction.members:
        number = number_in(d, scope.variables[member.name], w)
        is_named = is_named | candidate.eq(number)
    return inner.when(is_named)


def _entry_at(values: Value, axis: Axis, place: Value) -> Value:
    """Returns the entry of `values` at a place along an axis, `values[..., place]`.

    place: may differ along the other axes, and along axes that the values don't have.
    """
    dtype = values.dtype
    if values.axes == (axis,):
        return looked_up(values.node, place, dtype)
    has_row_each = values.axes == (*place.axes, axis) and len(place.axes) == 1
    if has_row_each and place.axes[0].size >= state_reads.MANY:
        return Value(call("entries_at", values.node, place.node), dtype, place.axes)
    axes = axes_of(values, place)
    if place.axes:
        places = aligned(place, axes)
    else:
        places = call("jnp.full", (1,) * len(axes), place.node)
    dimension = axes.index(axis)
    entry = call("jnp.take_along_axis", aligned(values, axes), places, axis=dimension)
    if axes[-1] == axis:
        node = entry[..., 0]
    else:
        node = entry[tuple(0 if a == axis else ALL for a in axes)]
    return Value(node, dtype, without(axes, (axis,)))


def bound(d: ir.Domain, member: Variable, scope: IterationScope, w: Writer) -> IterationScope:
    """Returns the scope with a domain's variable, and with that of `on` if the domain has one."""
    scope = scope.binding(d.var.name, member)
    if d.on is None or not isinstance(member, AgentVar):
        return scope
    site, _ = state_reads.site_under(member, d.on.kinds, w)
    return scope.binding(d.on.name, CellVar(site, d.on.kinds))


def nearest(d: ir.Domain, scope: IterationScope, w: Writer) -> tuple[IterationScope, Value]:
    """Lowers `first DOMAIN in beam of x`: the nearest member in each lane of the shape.

    Returns:
      the scope with one more axis, of the lanes, and without a mask; and which lanes have a member.
    """
    assert isinstance(d.restriction, ir.Near)
    shape = w.module.shape(d.restriction.shape)
    candidate, eligible = _on_cells(d, d.restriction, scope, w)
    axis = candidate.number.axes[-1]
    candidate_scope = replace(scope, axes=(*scope.axes, axis), mask=TRUE)
    candidate_scope = bound(d, candidate, candidate_scope, w)
    if d.on is not None:
        assert isinstance(candidate, AgentVar)
        _, is_on = state_reads.site_under(candidate, d.on.kinds, w)
        eligible = eligible & is_on
    if d.where is not None:
        eligible = eligible & w.value(d.where, candidate_scope)
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


def _on_cells(
    d: ir.Domain, near: ir.Near, scope: IterationScope, w: Writer
) -> tuple[Variable, Value]:
    """Returns the candidate on each cell of a shape, along its axis, and on which there is one."""
    entity_type = d.var.entity_type
    if entity_type.what == "cell":
        site, exists = sites_in(near, d.var.kinds, scope, w, d.var.name)
        return CellVar(site, d.var.kinds), exists
    swept = sweep(near, scope, w)
    axes = swept.cells.axes
    on_cells = stand_on(swept.cells, state_reads.positions(w, entity_type))
    standing = w.keep_node("standing", on_cells, "bool")
    first = Value(reduction("argmax", standing, (-1,)), "i32", axes)
    who = w.keep(d.var.name, first)
    has_body = Value(reduction("any", standing, (-1,)), "bool", axes)
    anybody = w.keep("anybody", has_body)
    return AgentVar(who, entity_type=entity_type), anybody & swept.unblocked

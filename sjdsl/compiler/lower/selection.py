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
    Axis,
    Value,
    aligned,
    as_dtype,
    axes_of,
    broadcast,
    iota,
    literal,
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
from sjdsl.compiler.lower.scope import AgentVar, CellVar, IterationScope, SetOfOne, Variable
from sjdsl.compiler.lower.writer import Writer
from sjdsl.compiler.program.expressions import (
    ALL,
    REST,
    Call,
    Expression,
    Lambda,
    Literal,
    Name,
    Slice,
    Where,
    call,
    constant,
    reduction,
    scalar,
)

MANY_SETS = 64  # from so many sets on, bits are drawn only if some set has several members


def mask_over(inner: IterationScope, axes: tuple[Axis, ...]) -> Value:
    """Returns the mask of a scope with all the axes spelt out."""
    return broadcast(inner.mask, axes)


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
        return (
            inner.when(scope.mask).when(there & (number > 0)),
            ~there,
            s.body,
        )
    axis = inner.axes[-1]
    member = inner.variables[s.domain.var.name]
    is_near = isinstance(s.domain.restriction, ir.Near) and isinstance(member, CellVar)
    total = axis.extent if is_near else w.module.extent(member.sort)
    if number == literal(1, "i32"):
        return *_pick_one(s, scope, inner, total, w), s.body
    turns = w.axis("turn", min(s.most, total.size))
    word = random_bits(s.stream, scope, w, turns)
    outer_axes = union(word.axes[:-1], without(inner.mask.axes, (axis,)))
    axes = (*outer_axes, axis)
    mask = w.keep("member", mask_over(inner, axes))
    found = w.keep(
        "found", Value(reduction("any", mask.node, (len(axes) - 1,)), "bool", outer_axes)
    )
    wanted = Value(scalar(number.node, "i32"), "i32") if number.literal else number
    if not turns.size:
        return inner.when(FALSE), ~found, s.body
    given = mask.node, spread(word, (*outer_axes, turns)), spread(wanted, outer_axes)
    chosen, body = call("choose", *given), s.body
    match s.body:
        case (ir.Chance(branches=(ir.Branch() as branch,), otherwise=()) as chance,) if (
            inner.digits == ((iota(axis), axis.extent),)
        ):
            w.origin = chance.origin
            limit = first_limit(branch.test, inner, w)
            if not limit.axes:  # the same for all members
                chosen = call("choose_by_chance", *given, KEY, w.stream(chance.stream), limit.node)
                body = branch.body
    w.origin = s.origin
    return (
        replace(inner, mask=scope.mask & w.keep("taken", Value(chosen, "bool", axes))),
        ~found,
        body,
    )


def _pick_one(
    s: ir.Pick, scope: IterationScope, inner: IterationScope, total: Literal, w: Writer
) -> tuple[IterationScope, Value]:
    """A `pick 1`: the number of the member instead of a mask over all."""
    axis, name = inner.axes[-1], s.domain.var.name
    member = inner.variables[name]
    word = random_bits(
        s.stream, scope, w
    )  # no axis for the one turn: on a GPU, XLA would store the words before it drops the axis
    members = whole_set(s.domain, scope, w)
    around = (members or inner.mask).axes
    axes = union(word.axes, without(around, (axis,)))
    drawn = spread(word, axes)
    source = aligned(members, axes) if members else mask_over(inner, (*axes, axis)).node
    large = members is not None and members.levels > 0
    many = (
        members is not None
        and not large
        and members.axes == axes
        and prod(a.size for a in axes) >= MANY_SETS
    )
    if many and need_no_state(scope.digits):  # most steps need none of the random bits
        assert members is not None
        if not _is_where_any(scope.mask, members, w):
            source = Where(aligned(scope.mask, axes), source, Literal(0))
        alone = call("pick_of_sets", source, KEY, Lambda(("key",), drawn))
        picked = w.keep("picked", Value(alone, w.module.set_dtype, axes))
        there = w.keep("found", picked.ne(0))
        best_one = w.keep(name, Value(call("member_of", picked.node), "i32", axes))
        chosen: Variable = AgentVar(best_one, alone=SetOfOne(picked, scope.mask & there))
    else:
        best, found = Name(w.names.fresh(name)), Name(w.names.fresh("found"))
        w.unpack(
            (best, found),
            call(
                ("pick_of_large_set" if large else "pick_of_set") if members else "pick",
                source,
                drawn,
            ),
        )
        there, best_one = Value(found, "bool", axes), Value(best, "i32", axes)
        if isinstance(member, AgentVar):
            chosen = AgentVar(best_one, sort=member.sort)
        else:  # its number, or the number at its place in a shape
            chosen = CellVar(
                best_one if member.axis is not None else _take(member.site, axis, best_one),
                member.kinds,
            )
    if isinstance(chosen, CellVar) and isinstance(chosen.site.node, Call):
        chosen = replace(chosen, site=w.keep(name, chosen.site))
    place = replace(
        scope.binding(**{name: chosen}, **under(s.domain, chosen, w)),
        digits=(*scope.digits, (best_one, total)),
    )
    return place.when(there), ~there


def _is_where_any(mask: Value, members: Value, w: Writer) -> bool:
    """Returns whether a mask takes no member from any set: it holds for all, or for those with members."""
    has_members = members.ne(0).node
    return mask == TRUE or mask.node in (has_members, w.known.get((has_members, "bool")))


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
        return Value(values.node[best.node], dtype, best.axes)
    is_row_each = values.axes == (*best.axes, axis) and len(best.axes) == 1
    if is_row_each and best.axes[0].size >= state_reads.MANY:
        return Value(call("entries_at", values.node, best.node), dtype, best.axes)
    # What is picked may differ along more axes than what it is picked from.
    axes = axes_of(values, best)
    if best.axes:
        at = aligned(best, axes)
    else:
        at = call("jnp.full", (Literal(1),) * len(axes), best.node)
    place = axes.index(axis)
    aligned_values = aligned(values, axes)
    entry = call("jnp.take_along_axis", aligned_values, at, axis=place)
    keys: tuple[Expression | Slice, ...]
    if axes[-1] == axis:
        keys = (REST, Literal(0))
    else:
        keys = tuple(Literal(0) if a == axis else ALL for a in axes)
    return Value(entry[keys], dtype, without(axes, (axis,)))


def under(d: ir.Domain, agent: Variable, w: Writer) -> dict[str, Variable]:
    """Returns the variable of the cell under an agent, if a domain binds one."""
    if d.on is None or not isinstance(agent, AgentVar):
        return {}
    site, _ = state_reads.site_under(agent, d.on.kinds, w)
    return {d.on.name: CellVar(site, d.on.kinds)}


def nearest(d: ir.Domain, scope: IterationScope, w: Writer) -> tuple[IterationScope, Axis, Value]:
    """Returns the scope of the nearest member in each lane, the lanes' axis, and its mask.

    The mask says where there is a member; the scope is without a mask.
    """
    assert isinstance(d.restriction, ir.Near)
    shape = w.module.shape(d.restriction.shape)
    candidate, ok, axis = _candidates(d, scope, w)
    place = replace(scope, axes=(*scope.axes, axis), mask=TRUE).binding(**{d.var.name: candidate})
    if d.on is not None:
        assert isinstance(candidate, AgentVar)
        place = place.binding(**under(d, candidate, w))
        _, is_on = state_reads.site_under(candidate, d.on.kinds, w)
        ok = ok & is_on
    if d.where is not None:
        ok = ok & w.value(d.where, place)
    outer = tuple(a for a in axes_of(ok, candidate.number) if a != axis)
    axes = (*outer, axis)
    ok = w.keep("eligible", broadcast(ok, axes))
    lanes = w.axis("lane", len(shape.lanes))
    numbers = spread(candidate.number, axes)
    if max(map(len, shape.lanes)) == 1:  # every cell is a lane
        number = w.keep(d.var.name, Value(numbers, "i32")).node
        exists = ok.node
    else:
        sizes = constant(tuple(map(len, shape.lanes)))
        pair = call("nearest_in_lanes", ok.node, numbers, sizes)
        number, exists = w.keep_parts((d.var.name, "found"), pair)
    chosen = Value(number, "i32", (*outer, lanes))
    variable: Variable
    if isinstance(candidate, AgentVar):
        variable = AgentVar(chosen, sort=candidate.sort)
    else:
        variable = CellVar(chosen, candidate.kinds)
    inner = replace(
        scope,
        axes=(*scope.axes, lanes),
        digits=(*scope.digits, (iota(lanes), lanes.extent)),
    )
    inner = inner.always().binding(**{d.var.name: variable}, **under(d, variable, w))
    return inner, lanes, Value(exists, "bool", (*outer, lanes))


def _candidates(d: ir.Domain, scope: IterationScope, w: Writer) -> tuple[Variable, Value, Axis]:
    """Returns who is on each cell of the shape, whether somebody is, and the shape's axis."""
    assert isinstance(d.restriction, ir.Near)
    if d.var.sort.what == "cell":
        site, axis, ok = sites_in(d.restriction, d.var.kinds, scope, w, d.var.name)
        return CellVar(site, d.var.kinds), ok, axis
    swept = sweep(d.restriction, scope, w)
    axes = swept.cells.axes
    on_cells = stand_on(swept.cells, state_reads.positions(w, d.var.sort))
    standing = w.keep("standing", Value(on_cells, "bool")).node
    first_one = reduction("argmax", standing, (-1,))
    who = w.keep(d.var.name, Value(first_one, "i32", axes))
    anybody = w.keep("anybody", Value(reduction("any", standing, (-1,)), "bool", axes))
    if has_inner_blocks(w.module.shape(d.restriction.shape), w):
        anybody = anybody & swept.ok
    return AgentVar(who, sort=d.var.sort), anybody, swept.axis

"""Lowers `count`, `sum`, `min` and `max` over domains.

A domain adds an axis, over which the members are reduced. Some domains have a faster form: all
cells of a kind, a set of agents kept as bits, and the cells around each cell.
"""

from math import isinf

from sjdsl.compiler import ir
from sjdsl.compiler.ir.operations import REDUCTIONS
from sjdsl.compiler.lower import state_reads
from sjdsl.compiler.lower.axes import (
    TRUE,
    Axes,
    Value,
    as_dtype,
    common,
    iota,
    literal,
    reduce,
    select,
    spread,
    union,
    without,
)
from sjdsl.compiler.lower.domains import enter, is_empty, neighbours_constant, shape_name, whole_set
from sjdsl.compiler.lower.scope import CellVar, IterationScope
from sjdsl.compiler.lower.writer import Writer
from sjdsl.compiler.program.expressions import (
    DType,
    Lambda,
    Unary,
    call,
    path,
)

LARGEST = 2**31 - 1  # of the whole numbers of the language
MOST = 32  # cells of a shape: each is a few lines of the program that XLA compiles
_PLAIN = (  # expressions that the function which `over_neighbours` calls may contain
    ir.Number, ir.Word, ir.Truth, ir.ParamRef, ir.Member, ir.Local, ir.At, ir.Named, ir.FieldRead,
    ir.Arithmetic, ir.Compare, ir.Same, ir.InRange, ir.InWords, ir.Not, ir.Logic, ir.Case,
    ir.Narrowed,
)  # fmt: skip


def is_over_neighbours(e: ir.Count | ir.Sum | ir.Extreme, scope: IterationScope, w: Writer) -> bool:
    """Returns whether `over_neighbours` can compute an aggregate.

    It can if the domain is the cells of one kind in a small shape around each cell, and what is
    computed of them reads plain fields of theirs: `sum(tree.height for tree in disc(2) of house)`.
    """
    d = e.domain
    if not isinstance(d.restriction, ir.Near) or d.var.entity_type.what != "cell":
        return False
    if len(d.var.kinds) != 1 or e.type.kind != "int":
        return False
    is_inside_another = bool(w.parameters)
    if is_inside_another:
        return False
    anchor = scope.variables[d.restriction.anchor.name]
    if not isinstance(anchor, CellVar) or anchor.painted is not None:
        return False
    if len(scope.axes) != 1 or anchor.number.axes != scope.axes:
        return False
    if anchor.axis is None and scope.axes[0].size < state_reads.MANY:
        return False
    shape = w.module.shape(d.restriction.shape)
    return _reads_fields_of(d, e) and shape.num_cells <= MOST


def _reads_fields_of(d: ir.Domain, e: ir.Count | ir.Sum | ir.Extreme) -> bool:
    """Returns whether an aggregate reads fields of its domain's cells, and all of it is plain."""
    nodes: list[ir.Node] = []
    if not isinstance(e, ir.Count):
        nodes += ir.walk(e.value)
    if d.where is not None:
        nodes += ir.walk(d.where)
    reads_field = False
    for node in nodes:
        if isinstance(node, ir.Expression) and not isinstance(node, _PLAIN):
            return False
        if isinstance(node, ir.FieldRead) and isinstance(node.owner, ir.Member):
            reads_field = reads_field or node.owner.name == d.var.name
    return reads_field


def over_neighbours(
    e: ir.Count | ir.Sum | ir.Extreme,
    scope: IterationScope,
    w: Writer,
    otherwise: Value | int = 0,
) -> Value:
    """Returns a count, a sum or an extreme over the cells around each cell.

        over_neighbours("sum", DISC_TREE, lambda tree, height: ..., state.tree_height)

    The kernel calls the function for each cell of the shape: with the numbers of the cells there,
    and with their fields that it reads.

    otherwise: the value where there is no cell.
    """
    d = e.domain
    assert isinstance(d.restriction, ir.Near)
    anchor = scope.variables[d.restriction.anchor.name]
    assert isinstance(anchor, CellVar)
    table = neighbours_constant(d.restriction, anchor, d.var.kinds, w)
    number = w.fresh(d.var.name)
    w.parameters[number] = number
    site = Value(number, "i32", scope.axes)
    inner = scope.always().binding(d.var.name, CellVar(site, d.var.kinds, beside=True))
    inner = inner.when(state_reads.is_site(site, d.var.kinds, w))
    if d.where is not None:
        inner = inner.when(w.value(d.where, inner))
    fold = "sum"
    value = inner.mask
    if not isinstance(e, ir.Count):
        value = select(inner.mask, as_dtype(w.value(e.value, inner), "i32"), otherwise)
    if isinstance(e, ir.Extreme):
        fold = REDUCTIONS[e.fn].array
    # Reading fields in the function has made them its parameters, after the number.
    stored_fields = [stored for stored in w.parameters if stored != number]
    names = [parameter.identifier for parameter in w.parameters.values()]
    function = Lambda(tuple(names), spread(value, scope.axes))
    w.names.taken.difference_update(names)  # they mean nothing outside
    w.parameters.clear()
    around = {} if anchor.axis is not None else {"around": anchor.number.node}
    node = call("over_neighbours", fold, table, function, *stored_fields, **around)
    return Value(node, "i32", scope.axes)


def count(e: ir.Count, scope: IterationScope, w: Writer) -> Value:
    """Returns how many members a domain has, with the axes of the surroundings it depends on."""
    if is_empty(e.domain, w):
        return literal(0, "i32")
    fast = _number_on_map(e.domain, w) or _size_of_set(e, scope, w) or _near(e, scope, w)
    if fast is not None:
        return fast
    name = _count_name(e.domain)
    if is_over_neighbours(e, scope, w):
        return w.keep(name, over_neighbours(e, scope, w))
    inner = enter(e.domain, scope.always(), w)
    added = without(inner.axes, scope.axes)
    if not added:
        return as_dtype(inner.mask, "i32")
    return w.keep(name, reduce("sum", inner.mask, added))


def total(e: ir.Sum, scope: IterationScope, w: Writer) -> Value:
    """Returns a sum over a domain, with the axes of the surroundings it depends on."""
    dtype: DType = "i32" if e.type.kind == "int" else "f32"
    if is_empty(e.domain, w):
        return literal(0, dtype)
    if is_over_neighbours(e, scope, w):
        return w.keep("total", over_neighbours(e, scope, w))
    inner = enter(e.domain, scope.always(), w)
    added = without(inner.axes, scope.axes)
    values = select(inner.mask, as_dtype(w.value(e.value, inner), dtype), 0)
    if added and w.exact and dtype == "f32":
        return w.keep("total", _exact_sum(values, added))
    return w.keep("total", reduce("sum", values, added))


def _count_name(d: ir.Domain) -> str:
    """Returns a name for how many members a domain has: `num_dirty_water`."""
    match d.where:
        case ir.Same(right=ir.Word(value=word)):
            return f"num_{word}_{d.var.name}"
        case _:
            return f"num_{d.var.name}"


def _number_on_map(d: ir.Domain, w: Writer) -> Value | None:
    """Returns `count(water)`, a constant: how many cells of a kind the map has."""
    if d.restriction or d.on or d.where or d.var.entity_type.what != "cell":
        return None
    return Value(w.module.num_cells(d.var.kinds), "i32")


def _exact_sum(values: Value, over: Axes) -> Value:
    """Returns the sum of reals over axes, which decides something."""
    axes = union(values.axes, over)
    places = tuple(axes.index(axis) for axis in over)
    node = call("exact_sum", spread(values, axes), places)
    return Value(node, "f32", without(axes, over))


def extreme(e: ir.Extreme, scope: IterationScope, w: Writer) -> Value:
    """Returns the least or greatest value over a domain, with the axes that it depends on."""
    reduction = REDUCTIONS[e.fn]
    dtype: DType = "i32" if e.type.kind == "int" else "f32"
    otherwise = None
    if e.otherwise is not None:
        otherwise = as_dtype(w.value(e.otherwise, scope), dtype)
    if is_empty(e.domain, w):
        assert otherwise is not None
        return otherwise
    neutral = _neutral(e, otherwise, dtype)
    if otherwise == neutral and is_over_neighbours(e, scope, w):
        return w.keep(reduction.kept, over_neighbours(e, scope, w, otherwise))
    inner = enter(e.domain, scope.always(), w)
    added = without(inner.axes, scope.axes)
    value = as_dtype(w.value(e.value, inner), dtype)
    mask = inner.mask
    if common(added, value.axes):
        if mask != TRUE and otherwise not in (None, neutral):
            mask = w.keep("member", mask)  # it is read twice
        value = reduce(reduction.array, select(mask, value, neutral), added)
        value = w.keep(reduction.kept, value)
        if otherwise == neutral:
            return value
    if otherwise is None or mask == TRUE:
        return value
    return select(w.keep("anybody", reduce("any", mask, added)), value, otherwise)


def _neutral(e: ir.Extreme, otherwise: Value | None, dtype: DType) -> Value:
    """Returns the value of those who are no members, which a `min` or `max` then never takes.

    otherwise: the result without members, which is taken as this value if it does.
    """
    is_min = REDUCTIONS[e.fn].nothing > 0
    if dtype == "f32":
        infinity = path("jnp.inf")
        return Value(infinity if is_min else Unary("-", infinity), "f32")
    worst = e.value.type.high if is_min else e.value.type.low  # of members
    if otherwise is not None and otherwise.literal:
        is_worse = otherwise.number >= worst if is_min else otherwise.number <= worst
        if is_worse:
            return otherwise
    if isinf(worst):
        return literal(LARGEST if is_min else -LARGEST - 1, "i32")
    return literal(int(worst), "i32")


def _size_of_set(e: ir.Count, scope: IterationScope, w: Writer) -> Value | None:
    """Returns `count(agent in SET)`, if nobody is ever away: the number of bits of the set."""
    members = whole_set(e.domain, scope, w)
    if members is None:
        return None
    kernel = "size_of_large_set" if members.row_dims else "size_of_set"
    size = Value(call(kernel, members.node), "i32", members.axes)
    return w.keep(_count_name(e.domain), size)


def _near(e: ir.Count, scope: IterationScope, w: Writer) -> Value | None:
    """Returns `count(tree as other in disc(2) of tree where …)`, if that is about `other` alone.

    The members are the same for all trees: a vector of bits, of which each tree masks those near.
    """
    d = e.domain
    if not isinstance(d.restriction, ir.Near) or d.var.entity_type.what != "cell":
        return None
    anchor = scope.variables[d.restriction.anchor.name]
    if not isinstance(anchor, CellVar) or anchor.axis is None or anchor.painted is not None:
        return None
    if d.where is not None:
        for node in ir.walk(d.where):
            if isinstance(node, ir.Member | ir.Local) and node.name != d.var.name:
                return None
    shape = w.module.shape(d.restriction.shape)
    masks = w.layout.near_table(anchor.kinds, shape, d.var.kinds)
    name = f"near_{shape_name(d.restriction.shape)}_{'_'.join(d.var.kinds)}"
    table = w.module.constant(name, masks, f"neighbours of each cell in {shape.name}, as bits")
    axis = w.axis(d.var.name, w.module.num_cells(d.var.kinds))
    member = TRUE
    if d.where is not None:
        other = CellVar(iota(axis), d.var.kinds, axis)
        member = w.value(d.where, scope.binding(d.var.name, other))
    vector = member.node if axis in member.axes else spread(member, (axis,))
    near = call("count_near", vector, table)
    return w.keep("near", Value(near, "i32", (anchor.axis,)))

"""Lowers `count`, `sum`, `min` and `max` over domains, with a fast form for neighbours on a fixed map."""

from dataclasses import replace
from math import isinf

from sjdsl.compiler import ir
from sjdsl.compiler.ir.operations import REDUCTIONS
from sjdsl.compiler.lower.axes import TRUE, Value, as_dtype, iota, literal, reduce, select, spread
from sjdsl.compiler.lower.domains import enter, is_empty, shape_name, whole_set
from sjdsl.compiler.lower.neighbours import is_over_neighbours, over_neighbours
from sjdsl.compiler.lower.scope import CellVar, IterationScope
from sjdsl.compiler.lower.writer import Writer
from sjdsl.compiler.program.expressions import DType, Unary, call, path

LARGEST = 2**31 - 1  # of the whole numbers of the language


def total(e: ir.Count | ir.Sum, scope: IterationScope, w: Writer) -> Value:
    """Returns a count or a sum, with the axes of the surroundings it depends on."""
    if is_empty(e.domain, w):
        return literal(0, "i32" if e.type.kind == "int" else "f32")
    if isinstance(e, ir.Count):
        quick = _size(e, scope, w) or _near(e, scope, w)
        if quick is not None:
            return quick
    if is_over_neighbours(e, scope, w):
        return w.keep(f"num_{e.domain.var.name}" if isinstance(e, ir.Count) else "total", over_neighbours(e, scope, w))
    inner = enter(e.domain, scope.always(), w)
    new = tuple(a for a in inner.axes if a not in scope.axes)
    if isinstance(e, ir.Count):
        counted = inner.mask if inner.mask is not None else TRUE
        if not new:
            return as_dtype(counted, "i32")
        return w.keep(f"num_{e.domain.var.name}", reduce("sum", counted, new))
    value = as_dtype(w.value(e.value, inner.always()), "i32" if e.type.kind == "int" else "f32")
    return w.keep("total", reduce("sum", select(inner.mask, value, literal(0, value.dtype)), new))


def extreme(e: ir.Extreme, scope: IterationScope, w: Writer) -> Value:
    """Returns the least or greatest value over a domain, with the axes of the surroundings it depends on."""
    dtype: DType = "i32" if e.type.kind == "int" else "f32"
    otherwise = None if e.otherwise is None else as_dtype(w.value(e.otherwise, scope.always()), dtype)
    if is_empty(e.domain, w):
        assert otherwise is not None
        return otherwise
    if e.otherwise is not None and otherwise == _nothing(e, otherwise, dtype) and is_over_neighbours(e, scope, w):
        return w.keep(REDUCTIONS[e.fn].kept, over_neighbours(e, scope, w, otherwise))
    inner = enter(e.domain, scope.always(), w)
    new = tuple(a for a in inner.axes if a not in scope.axes)
    value, mask = as_dtype(w.value(e.value, inner.always()), dtype), inner.mask
    if any(a in value.axes for a in new):
        nothing = _nothing(e, otherwise, dtype)
        if mask is not None and otherwise not in (None, nothing):
            mask = w.keep("member", mask)  # for it is read twice
        value = w.keep(REDUCTIONS[e.fn].kept, reduce(REDUCTIONS[e.fn].array, select(mask, value, nothing), new))
        if nothing == otherwise:
            return value
    if otherwise is None or mask is None:
        return value
    return select(w.keep("anybody", reduce("any", mask, new)), value, otherwise)


def _nothing(e: ir.Extreme, otherwise: Value | None, dtype: DType) -> Value:
    """Returns what stands for those who are no members: the value for none if it yields to all others, else one that does."""
    least = REDUCTIONS[e.fn].nothing > 0
    if dtype == "f32":
        infinity = path("jnp.inf")
        return Value(infinity if least else Unary("-", infinity), "f32")
    last = e.value.type.high if least else e.value.type.low
    if otherwise is not None and otherwise.literal and (otherwise.number >= last if least else otherwise.number <= last):
        return otherwise
    bound = LARGEST if least else -LARGEST - 1
    return literal(bound if isinf(last) else int(last), "i32")


def _size(e: ir.Count, scope: IterationScope, w: Writer) -> Value | None:
    """`count(agent in SET)` where nobody is ever away: the bits of the set itself."""
    members = whole_set(e.domain, scope, w)
    if members is None:
        return None
    size = call("size_of_large_set" if members.levels else "size_of_set", members.node)
    return w.keep(f"num_{e.domain.var.name}", replace(members, node=size, dtype="i32", levels=0))


def _near(e: ir.Count, scope: IterationScope, w: Writer) -> Value | None:
    """`count(K as other in disc(r) of k where …)` whose condition is about `other` alone: bits and popcount."""
    d = e.domain
    if not isinstance(d.restriction, ir.Near) or d.var.sort.what != "cell":
        return None
    anchor = scope.variables[d.restriction.anchor.name]
    if not isinstance(anchor, CellVar) or anchor.axis is None or anchor.painted is not None:
        return None
    if d.where is not None and _others(d.where, d.var.name):
        return None
    shape = w.module.shape(d.restriction.shape)
    masks = w.module.layout.near_table(anchor.kinds, shape, d.var.kinds)
    name = f"near_{shape_name(d.restriction.shape)}_{'_'.join(d.var.kinds)}"
    constant = w.module.constant(name, masks, f"neighbours of each cell in {shape.name}, as bits")
    axis = w.axis(d.var.name, w.module.num_cells(d.var.kinds))
    other = CellVar(iota(axis), d.var.kinds, axis)
    member = TRUE if d.where is None else w.value(d.where, scope.always().binding(**{d.var.name: other}))
    vector = member.node if axis in member.axes else spread(member, (axis,))
    return w.keep("near", Value(call("count_near", vector, constant), "i32", (anchor.axis,)))


def _others(test: ir.Expr, name: str) -> bool:
    """Returns whether a condition reads a variable other than `name`."""
    return any(isinstance(n, ir.Member | ir.Local) and n.name != name for n in ir.walk(test))

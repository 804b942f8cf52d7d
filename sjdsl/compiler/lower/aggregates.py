"""Lowers `count` and `sum` over domains, with a fast form for neighbours on a fixed map."""

from dataclasses import replace

from sjdsl.compiler import ir
from sjdsl.compiler.lower.axes import Value, as_dtype, literal, reduce, select
from sjdsl.compiler.lower.domains import enter, is_empty, whole_set
from sjdsl.compiler.lower.expressions import lower
from sjdsl.compiler.lower.scope import CellVar, Frame, Writer, iota


def total(e: ir.Count | ir.Sum, frame: Frame, w: Writer) -> Value:
    """Returns a count or a sum, with the axes of the surroundings it depends on."""
    if is_empty(e.domain, w):
        return literal(0, "i32" if e.type.kind == "int" else "f32")
    if isinstance(e, ir.Count):
        quick = _size(e, frame, w) or _near(e, frame, w)
        if quick is not None:
            return quick
    inner = enter(e.domain, frame.always(), w)
    new = tuple(a for a in inner.axes if a not in frame.axes)
    if isinstance(e, ir.Count):
        counted = inner.mask if inner.mask is not None else literal(True, "bool")
        if not new:
            return as_dtype(counted, "i32")
        name = f"num_{e.domain.var.name}"
        return w.keep(name, reduce("sum", counted, new))
    value = lower(e.value, inner.always(), w)
    value = as_dtype(value, "i32" if e.type.kind == "int" else "f32")
    masked = select(inner.mask, value, literal(0, value.dtype))
    return w.keep("total", reduce("sum", masked, new))


def _size(e: ir.Count, frame: Frame, w: Writer) -> Value | None:
    """`count(agent in SET)` where nobody is ever away: the bits of the set itself."""
    members = whole_set(e.domain, frame, w)
    if members is None:
        return None
    return w.keep(f"num_{e.domain.var.name}", replace(members, text=f"size_of_set({members.text})", dtype="i32"))


def _near(e: ir.Count, frame: Frame, w: Writer) -> Value | None:
    """`count(K as other in disc(r) of k where …)` whose condition is about `other` alone: bits and popcount."""
    d = e.domain
    if not isinstance(d.place, ir.Near) or d.var.who != "cell":
        return None
    anchor = frame.variables[d.place.anchor.name]
    if not isinstance(anchor, CellVar) or anchor.axis is None or getattr(anchor, "values", None) is not None:
        return None
    if d.where is not None and _others(d.where, d.var.name):
        return None
    layout = w.module.layout
    shape = w.module.shape(d.place.shape)
    size = layout.num_cells(d.var.kinds)
    masks = layout.near_table(anchor.kinds, shape, d.var.kinds)
    name = "".join(c if c.isalnum() else "_" for c in f"near_{d.place.shape}_{'_'.join(d.var.kinds)}")
    constant = w.module.constant(name.replace("__", "_"), masks, f"neighbours of each cell in {shape.name}, as bits")
    axis = w.axis(d.var.name, size)
    other = CellVar(iota(axis), d.var.kinds, axis)
    place = replace(frame.always(), variables={**frame.variables, d.var.name: other})
    member = literal(True, "bool") if d.where is None else lower(d.where, place, w)
    vector = member.text if axis in member.axes else f"jnp.full({size}, {member.text})"
    return w.keep("near", Value(f"count_near({vector}, {constant})", "i32", (anchor.axis,)))


def _others(test: ir.Expr, name: str) -> bool:
    """Returns whether a condition reads a variable other than `name`."""
    return any(isinstance(n, ir.Member | ir.Local) and n.name != name for n in ir.walk(test))

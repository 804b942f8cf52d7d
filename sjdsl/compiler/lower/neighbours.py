"""Lowers `count`, `sum`, `min` and `max` over the cells around each cell as a function of one of them, applied to one after another."""

from sjdsl.compiler import ir
from sjdsl.compiler.ir.operations import REDUCTIONS
from sjdsl.compiler.lower import state_reads
from sjdsl.compiler.lower.axes import TRUE, Value, as_dtype, literal, select, spread
from sjdsl.compiler.lower.domains import neighbours_constant
from sjdsl.compiler.lower.scope import CellVar, IterationScope
from sjdsl.compiler.lower.writer import Writer
from sjdsl.compiler.program.expressions import Lambda, Literal, Name, call

MOST = 32  # cells of a shape: each is a few lines of the program that XLA compiles
_PLAIN = (
    ir.Number,
    ir.Word,
    ir.Truth,
    ir.ParamRef,
    ir.Member,
    ir.Local,
    ir.At,
    ir.Named,
    ir.FieldRead,
    ir.Arithmetic,
    ir.Compare,
    ir.Same,
    ir.InRange,
    ir.InWords,
    ir.Not,
    ir.Logic,
    ir.Case,
    ir.Narrowed,
)


def is_over_neighbours(e: ir.Count | ir.Sum | ir.Extreme, scope: IterationScope, w: Writer) -> bool:
    """Returns whether a domain is the cells of a small shape around each cell, and what is asked about them is plain."""
    d = e.domain
    if not isinstance(d.restriction, ir.Near) or d.var.sort.what != "cell" or len(d.var.kinds) != 1 or w.parameters or e.type.kind != "int":
        return False
    anchor = scope.variables[d.restriction.anchor.name]
    if not isinstance(anchor, CellVar) or anchor.painted is not None or len(scope.axes) != 1 or anchor.site.axes != scope.axes:
        return False
    if anchor.axis is None and scope.axes[0].size < state_reads.MANY:
        return False
    asked = [x for x in (d.where, None if isinstance(e, ir.Count) else e.value) if x is not None]
    nodes = [n for x in asked for n in ir.walk(x)]
    if not all(isinstance(n, _PLAIN) for n in nodes if isinstance(n, ir.Expression)):
        return False
    fields = any(isinstance(n, ir.FieldRead) and isinstance(n.owner, ir.Member) and n.owner.name == d.var.name for n in nodes)
    return fields and sum(map(len, w.module.shape(d.restriction.shape).lanes)) <= MOST


def over_neighbours(e: ir.Count | ir.Sum | ir.Extreme, scope: IterationScope, w: Writer, otherwise: Value | None = None) -> Value:
    """Returns a count, a sum or an extreme over the cells around each cell. `otherwise`: what stands for no cell."""
    d = e.domain
    assert isinstance(d.restriction, ir.Near)
    anchor = scope.variables[d.restriction.anchor.name]
    assert isinstance(anchor, CellVar)
    (axis,) = scope.axes
    table = neighbours_constant(d.restriction, anchor, d.var.kinds, w)
    number = Name(w.names.fresh(d.var.name))
    site = Value(number, "i32", (axis,))
    w.parameters[number] = number
    inner = scope.always().binding(**{d.var.name: CellVar(site, d.var.kinds, beside=True)}).when(state_reads.is_site(site, d.var.kinds, w))
    if d.where is not None:
        inner = inner.when(w.value(d.where, inner.always()))
    fold = "sum" if isinstance(e, ir.Count | ir.Sum) else REDUCTIONS[e.fn].array
    if isinstance(e, ir.Count):
        value = inner.mask or TRUE
    else:
        nothing = literal(0, "i32") if otherwise is None else otherwise
        value = select(inner.mask, as_dtype(w.value(e.value, inner.always()), "i32"), nothing)
    _, *given = w.parameters.items()
    body = Lambda((number.identifier, *(name.identifier for _, name in given)), spread(value, (axis,)))
    w.names.taken.difference_update(name.identifier for name in w.parameters.values())  # they mean nothing outside
    w.parameters.clear()
    some = {} if anchor.axis is not None else {"around": anchor.site.node}
    return Value(call("over_neighbours", Literal(fold), table, body, *(stored for stored, _ in given), **some), "i32", (axis,))

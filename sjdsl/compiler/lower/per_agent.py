"""Lowers what a statement says of agents to one value for each agent, whatever instances it is said in."""

from sjdsl.compiler import ir
from sjdsl.compiler.lower.axes import TRUE, Value, literal, reduce, select, spread, union
from sjdsl.compiler.lower.expressions import owner
from sjdsl.compiler.lower.scope import AgentVar, IterationScope
from sjdsl.compiler.lower.writer import Writer
from sjdsl.compiler.program import expressions as array


def per_agent(e: ir.Expr, scope: IterationScope, w: Writer) -> Value:
    """Returns which agents a statement reaches, `[N]` bool."""
    who = owner(e, scope, w)
    assert isinstance(who, AgentVar)
    mask = scope.mask or TRUE
    if who.axis is not None:
        hit = reduce("any", mask, tuple(a for a in scope.axes if a != who.axis))
        return hit if hit.axes else Value(array.call("jnp.full", w.module.extent(who.sort), hit.node), "bool")
    extent = w.module.extent(who.sort)
    at = w.keep(f"to_{who.sort.name}", select(scope.mask, who.index, Value(extent, "i32")))
    nobody = array.call("jnp.zeros", extent, array.DTYPES["bool"])
    return Value(array.Update(nobody, (at.node,), "set", array.Literal(True), drop=True), "bool")


def of_each(e: ir.Expr, value: Value, scope: IterationScope, w: Writer) -> array.Expression:
    """Returns a number from 0 on for each agent that a statement reaches, `[N]` int32, anything for the others.

    All instances that reach an agent say the same.
    """
    who = owner(e, scope, w)
    assert isinstance(who, AgentVar)
    if who.axis is None:
        extent = w.module.extent(who.sort)
        at = select(scope.mask, who.index, Value(extent, "i32"))
        axes = union(at.axes, value.axes)
        places = w.keep(f"to_{who.sort.name}", Value(spread(at, axes), "i32", axes)).node
        zeros = array.call("jnp.zeros", extent, array.DTYPES["i32"])
        return array.Update(zeros, (places,), "set", spread(value, axes), drop=True)
    over = tuple(a for a in value.axes if a != who.axis)
    if over:
        value = reduce("max", select(scope.mask, value, literal(0, "i32")), tuple(a for a in scope.axes if a != who.axis))
    return value.node if value.axes else array.call("jnp.full", w.module.extent(who.sort), value.node)

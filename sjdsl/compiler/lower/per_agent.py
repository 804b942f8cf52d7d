"""Arrays with one entry for each agent: whom a statement reaches, and what it changes of them."""

from sjdsl.compiler import ir
from sjdsl.compiler.ir.names import attribute_of
from sjdsl.compiler.lower.axes import (
    Value,
    literal,
    reduce,
    select,
    spread,
    union,
)
from sjdsl.compiler.lower.draws import KEY
from sjdsl.compiler.lower.expressions import agent
from sjdsl.compiler.lower.scope import IterationScope
from sjdsl.compiler.lower.writer import Writer
from sjdsl.compiler.program import expressions as array
from sjdsl.runtime.actions import HEADINGS


def per_agent(e: ir.Expr, scope: IterationScope, w: Writer) -> Value:
    """Returns which agents a statement reaches, `[N]` bool."""
    who = agent(e, scope, w)
    if who.axis is not None:
        hit = reduce("any", scope.mask, tuple(a for a in scope.axes if a != who.axis))
        return (
            hit
            if hit.axes
            else Value(array.call("jnp.full", w.module.extent(who.sort), hit.node), "bool")
        )
    extent = w.module.extent(who.sort)
    at = w.keep(f"to_{who.sort.name}", select(scope.mask, who.index, Value(extent, "i32")))
    nobody = array.call("jnp.zeros", extent, array.DTYPES["bool"])
    return Value(array.Update(nobody, (at.node,), "set", array.Literal(True), drop=True), "bool")


def of_each(e: ir.Expr, value: Value, scope: IterationScope, w: Writer) -> array.Expression:
    """Returns a number from 0 on for each agent that a statement reaches, `[N]` int32, anything for the others.

    All instances that reach an agent say the same.
    """
    who = agent(e, scope, w)
    if who.axis is None:
        extent = w.module.extent(who.sort)
        at = select(scope.mask, who.index, Value(extent, "i32"))
        axes = union(at.axes, value.axes)
        places = w.keep(f"to_{who.sort.name}", Value(spread(at, axes), "i32", axes)).node
        zeros = array.call("jnp.zeros", extent, array.DTYPES["i32"])
        return array.Update(zeros, (places,), "set", spread(value, axes), drop=True)
    over = tuple(a for a in value.axes if a != who.axis)
    if over:
        value = reduce(
            "max",
            select(scope.mask, value, literal(0, "i32")),
            tuple(a for a in scope.axes if a != who.axis),
        )
    return (
        value.node if value.axes else array.call("jnp.full", w.module.extent(who.sort), value.node)
    )


def put(
    name: str, sort: ir.Sort, who: array.Expression, value: array.Expression, w: Writer
) -> None:
    """Gives a fact about some agents, or some movers of a sort, a new value."""
    attribute = attribute_of(name, sort)
    w.assign(attribute, array.Where(who, value, w.current(attribute)))


def turn(
    sort: ir.Sort, who: array.Expression, facing: str | None, stream: int | None, w: Writer
) -> None:
    """Turns some agents or movers as a statement says; the heading of a mover is a field, and so a byte."""
    heading: array.Expression
    if facing == "same":
        return
    if facing is None:
        assert stream is not None
        heading = array.call(
            "below",
            array.call("random_bits", KEY, w.stream(stream), w.module.extent(sort)),
            array.Literal(4),
        )
        heading = array.Cast(heading, "u8") if sort.what == "mover" else heading
    else:
        heading = w.module.number(facing, HEADINGS.index(facing))
        heading = array.scalar(heading, "u8") if sort.what == "mover" else heading
    put("heading", sort, who, heading, w)


def any_of(who: list[array.Expression]) -> array.Expression:
    first, *rest = who
    for other in rest:
        first = array.Binary("|", first, other)
    return first

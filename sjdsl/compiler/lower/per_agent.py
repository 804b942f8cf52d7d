"""Arrays with an entry for each agent, or each mover of a name: whom a statement reaches."""

from sjdsl.compiler import ir
from sjdsl.compiler.ir.names import attribute_of
from sjdsl.compiler.lower.axes import (
    TRUE,
    Axes,
    Value,
    as_dtype,
    literal,
    looked_up,
    reduce,
    select,
    spread,
    union,
    without,
)
from sjdsl.compiler.lower.draws import bits_of_each
from sjdsl.compiler.lower.expressions import agent
from sjdsl.compiler.lower.scope import AgentVar, IterationScope
from sjdsl.compiler.lower.writer import Writer
from sjdsl.compiler.program.expressions import (
    DType,
    Expression,
    Part,
    Where,
    as_array,
    call,
    constant,
    written,
    zeros,
)
from sjdsl.runtime.actions import HEADINGS


def per_agent(name: str, e: ir.Expr, scope: IterationScope, w: Writer) -> Expression:
    """Returns which agents a statement reaches, `[N]` bool, under a name."""
    who = agent(e, scope, w)
    extent = w.module.extent(who.entity_type)
    if who.axis is not None:
        reached = reduce("any", scope.mask, without(scope.axes, (who.axis,)))
        node = reached.node if reached.axes else call("jnp.full", extent, reached.node)
    else:
        node = to_each(who, TRUE, scope, w)
    return w.keep_node(name, node, "bool")


def to_each(
    who: AgentVar, value: Value, scope: IterationScope, w: Writer, entries: Axes = ()
) -> Expression:
    """Returns a value for each agent that a statement reaches by computed numbers; 0 for others.

    entries: the axes of one agent's value; `[N, *entries]`.
    """
    extent = w.module.extent(who.entity_type)
    at = select(scope.mask, who.number, extent)
    axes = union(at.axes, without(value.axes, entries))
    places = w.keep_node(f"to_{who.entity_type.name}", spread(at, axes), "i32")
    none = zeros(value.dtype, extent, *(axis.extent for axis in entries))
    new = value.node if value.literal else spread(value, (*axes, *entries))
    return written("set_at", none, (places,), new)


def of_each(e: ir.Expr, value: Value, scope: IterationScope, w: Writer) -> Expression:
    """Returns a number from 0 on for each agent that a statement reaches, `[N]` int32.

    All instances that reach an agent have the same number for it; agents that none reaches get
    any number.
    """
    who = agent(e, scope, w)
    if who.axis is None:
        return to_each(who, value, scope, w)
    if any(a != who.axis for a in value.axes):
        others = without(scope.axes, (who.axis,))
        value = reduce("max", select(scope.mask, value, 0), others)
    if value.axes:
        return value.node
    return call("jnp.full", w.module.extent(who.entity_type), value.node)


def way_of_each(
    e: ir.Expr, way: ir.Expr | None, scope: IterationScope, w: Writer
) -> Expression | None:
    """Returns the heading that a statement gives each agent or mover it reaches, `[N]` int32."""
    if way is None:
        return None
    return w.keep_node("way", of_each(e, written_heading(way, 0, scope, w), scope, w), "i32")


def written_heading(heading: ir.Expr, quarters: int, scope: IterationScope, w: Writer) -> Value:
    """Returns a heading turned by so many quarters to the right, as a number from 0 to 3."""
    numbers = [HEADINGS.index(word) for word in heading.type.words]
    value = w.value(heading, scope)
    if value.literal:
        return literal((numbers[int(value.number)] + quarters) % 4, "i32")
    if numbers == list(range(len(HEADINGS))):
        return turned(as_dtype(value, "i32"), quarters)
    table = as_array([(n + quarters) % 4 for n in numbers], "i32")
    return looked_up(table, value, "i32")


def turned(heading: Value, quarters: int) -> Value:
    """Returns a heading turned by so many quarters to the right."""
    return (heading + quarters) & 3 if quarters else heading


def put(name: str, entity_type: ir.EntityType, who: Expression, value: Part, w: Writer) -> None:
    """Writes a new value of an attribute for some agents, or some movers of a name.

    who: which of them, `[N]` bool.
    """
    attribute = attribute_of(name, entity_type)
    w.assign(attribute, Where(who, constant(value), w.current(attribute)))


def turn(
    entity_type: ir.EntityType,
    who: Expression,
    facing: str | None,
    way: Expression | None,
    stream: int | None,
    w: Writer,
) -> None:
    """Turns some agents or movers: north, east, ..., to any heading (None), or not at all ("same").

    way: the heading of each, `[N]` int32, instead of `facing`. The heading of a mover is a field of
    words, and so a byte.
    """
    if facing == "same":
        return
    if way is None and facing is not None:
        way = w.module.number(facing, HEADINGS.index(facing))
    elif way is None:
        assert stream is not None
        way = call("below", bits_of_each(stream, entity_type, w), 4)
    dtype: DType = "u8" if entity_type.what == "mover" else "i32"
    put("heading", entity_type, who, as_dtype(Value(way, "i32"), dtype).node, w)

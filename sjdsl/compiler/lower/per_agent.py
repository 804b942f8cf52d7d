"""Arrays with an entry for each agent, or each mover of a name: what a statement does to whom.

The instances of a statement name agents in one of two ways. In `each agent as victim { send victim
to gate }`, `victim` is along an axis: each agent once, in order. In `send tree.owner to gate` they
are computed numbers, several of which may be the same agent; these are scattered to their agents.
"""

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
    """Returns which agents some instance of a statement names, `[N]` bool.

    Args:
      name: of the variable in generated code.
      e: the agent or mover that each instance names.
    """
    agents = agent(e, scope, w)
    if agents.axis is None:
        return w.keep_node(name, scattered(agents, TRUE, scope, w), "bool")
    other_axes = without(scope.axes, (agents.axis,))
    is_named = reduce("any", scope.mask, other_axes)
    return w.keep_node(name, _repeated(is_named, agents, w), "bool")


def _repeated(value: Value, agents: AgentVar, w: Writer) -> Expression:
    """Returns a value of each agent, or of all, with an entry for each: `[N]`."""
    if value.axes:
        return value.node
    return call("jnp.full", w.module.extent(agents.entity_type), value.node)


def scattered(
    agents: AgentVar, value: Value, scope: IterationScope, w: Writer, entries: Axes = ()
) -> Expression:
    """Returns the value of each agent that some instance names by its number; 0 for others.

    Args:
      agents: computed numbers.
      value: of each instance; those that name one agent have the same for it.
      entries: the axes of a single agent's value.

    Returns:
      `[N, *entries]`.
    """
    extent = w.module.extent(agents.entity_type)
    # An instance that doesn't happen writes past the end, which is dropped.
    numbers = select(scope.mask, agents.number, extent)
    axes = union(numbers.axes, without(value.axes, entries))
    places = w.keep_node(f"to_{agents.entity_type.name}", spread(numbers, axes), "i32")
    entry_shape = [axis.extent for axis in entries]
    none = zeros(value.dtype, extent, *entry_shape)
    new = value.node if value.literal else spread(value, (*axes, *entries))
    return written("set_at", none, (places,), new)


def of_each(e: ir.Expr, value: Value, scope: IterationScope, w: Writer) -> Expression:
    """Returns the value of each agent that some instance names, `[N]` int32; any for others.

    Args:
      e: the agent or mover that each instance names.
      value: of each instance, from 0 on; those that name one agent have the same for it.
    """
    agents = agent(e, scope, w)
    if agents.axis is None:
        return scattered(agents, value, scope, w)
    if any(axis != agents.axis for axis in value.axes):
        other_axes = without(scope.axes, (agents.axis,))
        value = reduce("max", select(scope.mask, value, 0), other_axes)
    return _repeated(value, agents, w)


def way_of_each(
    e: ir.Expr, way: ir.Expr | None, scope: IterationScope, w: Writer
) -> Expression | None:
    """Returns the heading that a statement gives to each agent that it names, `[N]` int32.

    Args:
      e: the agent or mover that each instance names.
      way: the heading that it gives; None if it gives none, as the result is then.
    """
    if way is None:
        return None
    heading = written_heading(way, 0, scope, w)
    return w.keep_node("way", of_each(e, heading, scope, w), "i32")


def written_heading(heading: ir.Expr, quarters: int, scope: IterationScope, w: Writer) -> Value:
    """Returns a heading turned by so many quarters to the right, as a number from 0 to 3.

    heading: of an enum of headings, which may have only some of them, or another order.
    """
    headings = [HEADINGS.index(word) for word in heading.type.words]
    place = w.value(heading, scope)  # in its enum
    if place.literal:
        return literal((headings[int(place.number)] + quarters) % 4, "i32")
    if headings == list(range(len(HEADINGS))):
        return turned(as_dtype(place, "i32"), quarters)
    table = as_array([(number + quarters) % 4 for number in headings], "i32")
    return looked_up(table, place, "i32")


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
    """Writes the new headings of some agents, or of some movers of a name.

    Args:
      who: which of them, `[N]` bool.
      facing: the heading of all, such as "north"; None: a random one each; "same": nobody turns.
      way: the heading of each, `[N]` int32, instead of `facing`.
      stream: of the random headings.
    """
    if facing == "same":
        return
    if way is None and facing is not None:
        way = w.module.number(facing, HEADINGS.index(facing))
    elif way is None:
        assert stream is not None
        way = call("below", bits_of_each(stream, entity_type, w), 4)
    # A mover's heading is stored as a byte, like all fields that hold enum values.
    dtype: DType = "u8" if entity_type.what == "mover" else "i32"
    put("heading", entity_type, who, as_dtype(Value(way, "i32"), dtype).node, w)

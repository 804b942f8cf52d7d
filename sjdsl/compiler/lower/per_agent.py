"""Arrays with an entry for each agent, or each mover of a name: whom a statement reaches."""

from sjdsl.compiler import ir
from sjdsl.compiler.ir.names import attribute_of
from sjdsl.compiler.lower.axes import (
    Value,
    axes_of,
    literal,
    reduce,
    select,
    spread,
    without,
)
from sjdsl.compiler.lower.draws import KEY
from sjdsl.compiler.lower.expressions import agent
from sjdsl.compiler.lower.scope import IterationScope
from sjdsl.compiler.lower.writer import Writer
from sjdsl.compiler.program.expressions import (
    Cast,
    Expression,
    Literal,
    Where,
    call,
    scalar,
    written,
    zeros,
)
from sjdsl.runtime.actions import HEADINGS


def per_agent(e: ir.Expr, scope: IterationScope, w: Writer) -> Value:
    """Returns which agents a statement reaches, `[N]` bool."""
    who = agent(e, scope, w)
    extent = w.module.extent(who.sort)
    if who.axis is not None:
        reached = reduce("any", scope.mask, without(scope.axes, (who.axis,)))
        if reached.axes:
            return reached
        return Value(call("jnp.full", extent, reached.node), "bool")
    at = w.keep(f"to_{who.sort.name}", select(scope.mask, who.index, Value(extent, "i32")))
    nobody = zeros("bool", extent)
    return Value(written("set_at", nobody, (at.node,), Literal(True)), "bool")


def of_each(e: ir.Expr, value: Value, scope: IterationScope, w: Writer) -> Expression:
    """Returns a number from 0 on for each agent that a statement reaches, `[N]` int32.

    All instances that reach an agent have the same number for it; agents that none reaches get
    any number.
    """
    who = agent(e, scope, w)
    extent = w.module.extent(who.sort)
    if who.axis is None:
        at = select(scope.mask, who.index, Value(extent, "i32"))
        axes = axes_of(at, value)
        places = w.keep_node(f"to_{who.sort.name}", spread(at, axes), "i32")
        none = zeros("i32", extent)
        return written("set_at", none, (places,), spread(value, axes))
    if any(a != who.axis for a in value.axes):
        others = without(scope.axes, (who.axis,))
        value = reduce("max", select(scope.mask, value, literal(0, "i32")), others)
    return value.node if value.axes else call("jnp.full", extent, value.node)


def put(name: str, sort: ir.Sort, who: Expression, value: Expression, w: Writer) -> None:
    """Writes a new value of an attribute for some agents, or some movers of a name.

    who: which of them, `[N]` bool.
    """
    attribute = attribute_of(name, sort)
    w.assign(attribute, Where(who, value, w.current(attribute)))


def turn(sort: ir.Sort, who: Expression, facing: str | None, stream: int | None, w: Writer) -> None:
    """Turns some agents or movers: north, east, ..., to any heading (None), or not at all ("same").

    The heading of a mover is a field of words, and so a byte.
    """
    if facing == "same":
        return
    is_byte = sort.what == "mover"
    heading: Expression
    if facing is None:
        assert stream is not None
        bits = call("random_bits", KEY, w.stream(stream), w.module.extent(sort))
        heading = call("below", bits, 4)
        if is_byte:
            heading = Cast(heading, "u8")
    else:
        heading = w.module.number(facing, HEADINGS.index(facing))
        if is_byte:
            heading = scalar(heading, "u8")
    put("heading", sort, who, heading, w)


def any_of(masks: list[Expression]) -> Expression:
    first, *others = masks
    for other in others:
        first = first | other
    return first

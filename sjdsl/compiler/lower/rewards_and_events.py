"""Lowers `give` and `tally`: sums rewards and event counts over all instances of a statement."""

import math
from dataclasses import replace

from sjdsl.compiler import ir
from sjdsl.compiler.ir.names import param_attribute
from sjdsl.compiler.ir.queries import event_named
from sjdsl.compiler.lower.axes import (
    TRUE,
    Axes,
    Axis,
    Value,
    aligned,
    as_dtype,
    axes_of,
    joined,
    literal,
    one_hot,
    reduce,
    select,
    spread,
    without,
)
from sjdsl.compiler.lower.condition_names import value_name
from sjdsl.compiler.lower.domains import in_set
from sjdsl.compiler.lower.entries import row_key
from sjdsl.compiler.lower.expressions import agent, real
from sjdsl.compiler.lower.scope import AgentVar, IterationScope
from sjdsl.compiler.lower.writer import Writer
from sjdsl.compiler.program.expressions import (
    Expression,
    Literal,
    call,
    scalar,
)

MANY = 64  # instances from which on agents are counted by the bits of sets


def give(s: ir.Give, scope: IterationScope, w: Writer) -> None:
    """Adds to the rewards of this step."""
    amount = real(s.value, scope, w)
    named = "" if isinstance(s.value, ir.Number) else value_name(s.value)
    name = f"num_{named}" if named else "times"  # how often each agent gets it
    if s.receiver is not None:
        deliver("reward", _received(s.receiver, amount, scope, w, name), w)
        return
    reached = scope.mask
    if s.but is not None:
        is_left_out = one_hot(agent(s.but, scope, w).number, w.axis("receiver", w.module.agents))
        reached = scope.mask & ~is_left_out
    deliver("reward", _summed(reached, amount, scope.axes, w, name), w)


def tally(s: ir.Tally, scope: IterationScope, w: Writer) -> None:
    """Counts an event."""
    event = event_named(w.module.game, s.event)
    attribute = f"event_{param_attribute(s.event)}"
    amount = literal(1, "i32") if s.amount is None else as_dtype(w.value(s.amount, scope), "i32")
    if s.word is None:
        _count(s, attribute, None, amount, scope, w)
        return
    assert event.by is not None, event
    key = row_key(s.word, event.by, scope, w)
    if key.literal:
        _count(s, attribute, key.node, amount, scope, w)
        return
    if isinstance(s.receiver, ir.Member):
        agents = scope.variables[s.receiver.name].axis
        if agents is not None and scope.axes == (agents,):
            # All columns at once: one sum instead of an update for each.
            column = w.axis("word", w.module.num_entries(event.by))
            counts = _received(s.receiver, amount, scope.when(one_hot(key, column)), w, s.event)
            # The word may be the same for all agents.
            deliver(attribute, replace(counts, node=aligned(counts, (agents, column))), w)
            return
    for entry in event.by.entries:
        word = as_dtype(w.module.entry(entry), key.dtype)
        _count(s, attribute, word.node, amount, scope.when(key.eq(word)), w)


def _count(
    s: ir.Tally,
    attribute: str,
    column: Expression | None,
    amount: Value,
    scope: IterationScope,
    w: Writer,
) -> None:
    """Adds to an event's count, for the whole game or for those who receive it."""
    if s.receiver is not None:
        amounts = _received(s.receiver, amount, scope, w, s.event)
    else:
        amounts = _summed(scope.mask, amount, scope.axes, w, s.event)
    deliver(attribute, amounts, w, column)


def deliver(attribute: str, amounts: Value, w: Writer, column: Expression | None = None) -> None:
    """Adds to an attribute of the outcome, or to a column of it."""
    if amounts.literal and not amounts.number:
        return
    before = w.total(attribute)
    if column is None:
        w.accumulate(attribute, joined("+", before, amounts.node))
    else:
        w.accumulate(attribute, call("add_to_entry", before, column, amounts.node))


def _received(e: ir.Expr, amount: Value, scope: IterationScope, w: Writer, name: str) -> Value:
    """Returns what each agent gets in all: `[N]`, or a number if that is the same for all.

    name: of how often it gets the amount.
    """
    axis = w.axis("receiver", w.module.agents)
    is_large = math.prod(a.size for a in scope.axes) >= MANY
    by_bits = is_large and not amount.axes and axis.size <= 32
    if e.type.kind == "agents":
        members = w.value(e, scope)
        if by_bits:
            return _counted(select(scope.mask, members, 0), amount, axis, scope, w, name)
        return _summed(scope.mask & in_set(members, axis), amount, scope.axes, w, name)
    who = agent(e, scope, w)
    if who.axis is not None:
        return _summed(scope.mask, amount, without(scope.axes, (who.axis,)), w, name)
    if by_bits:
        return _counted(_alone(who, scope, w), amount, axis, scope, w, name)
    if scope.mask == TRUE or not who.number.axes:
        reached = scope.mask & one_hot(who.number, axis)
        return _summed(reached, amount, scope.axes, w, name)
    return _summed_by_agent(who.number, amount, axis, scope, w, name)


def _summed_by_agent(
    index: Value, amount: Value, axis: Axis, scope: IterationScope, w: Writer, name: str
) -> Value:
    """Returns what each agent gets in all from the instances, each of which names one."""
    is_same = not any(a in amount.axes for a in scope.axes)
    amounts = scope.mask if is_same else select(scope.mask, amount, 0)
    axes = axes_of(index, amounts)
    node = call("segment_sum", spread(amounts, axes), spread(index, axes), axis.extent)
    alike = literal(math.prod(a.size for a in without(scope.axes, axes)), "i32")
    if is_same:
        return _times(alike * w.keep(name, Value(node, "i32", (axis,))), amount)
    return _times(alike, Value(node, amount.dtype, (axis,)))


def _alone(who: AgentVar, scope: IterationScope, w: Writer) -> Value:
    """Returns an agent of each instance as a set of one, empty if the instance does not happen."""
    if who.alone is None:
        dtype = w.module.set_dtype
        bit = scalar(Literal(1), dtype) << as_dtype(who.number, dtype).node
        return select(scope.mask, replace(who.number, node=bit, dtype=dtype), 0)
    members = who.alone.members
    named_mask = w.keep("active", who.alone.mask)  # as a block may have named it
    if scope.mask in (who.alone.mask, named_mask):
        return members
    return select(scope.mask, members, 0)


def _counted(
    sets: Value, amount: Value, axis: Axis, scope: IterationScope, w: Writer, name: str
) -> Value:
    """Returns an amount times the number of instances whose set an agent is in."""
    count = w.keep(name, Value(call("times_in", sets.node, axis.extent), "i32", (axis,)))
    alike = literal(math.prod(a.size for a in without(scope.axes, sets.axes)), "i32")
    return _times(count, _times(alike, amount))


def _summed(reached: Value, amount: Value, over: Axes, w: Writer, name: str) -> Value:
    """Returns the sum over the instances that are reached.

    Where all give the same, they are counted, which is cheaper than adding.
    """
    if reached == TRUE:
        return reduce("sum", amount, over)
    if over and not any(axis in amount.axes for axis in over):
        return _times(w.keep(name, reduce("sum", reached, over)), amount)
    return reduce("sum", select(reached, amount, 0), over)


def _times(count: Value, amount: Value) -> Value:
    return as_dtype(count, amount.dtype) * amount

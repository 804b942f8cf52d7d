"""Lowers `give` and `tally`: sums rewards and event counts over all instances of a statement."""

import math
from dataclasses import replace

from sjdsl.compiler import ir
from sjdsl.compiler.ir.names import param_attribute
from sjdsl.compiler.ir.queries import event_named
from sjdsl.compiler.lower.axes import (
    TRUE,
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
        deliver("reward", per_agent(s.receiver, amount, scope, w, name), w)
        return
    reached = scope.mask
    if s.but is not None:
        is_left_out = one_hot(agent(s.but, scope, w).index, w.axis("receiver", w.module.agents))
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
    key = row_key(s.word, event.by, scope.always(), w)
    if key.literal:
        _count(s, attribute, key.node, amount, scope, w)
        return
    who = scope.variables[s.receiver.name] if isinstance(s.receiver, ir.Member) else None
    agents = (
        who.axis
        if isinstance(who, AgentVar) and who.axis is not None and scope.axes == (who.axis,)
        else None
    )
    if (
        agents is not None and s.receiver is not None
    ):  # all columns at once: one sum instead of an update for each
        column = w.axis("word", w.module.num_entries(event.by))
        here = scope.when(one_hot(key, column))
        got = per_agent(s.receiver, amount, here, w, s.event)
        # the word may be the same for all agents
        deliver(attribute, replace(got, node=aligned(got, (agents, column))), w)
        return
    for word in (
        as_dtype(w.module.entry(entry), key.dtype) for entry in event.by.entries
    ):  # it differs: one column at a time
        here = scope.when(key.eq(word))
        _count(s, attribute, word.node, amount, here, w)


def _count(
    s: ir.Tally,
    attribute: str,
    column: Expression | None,
    amount: Value,
    scope: IterationScope,
    w: Writer,
) -> None:
    if s.receiver is not None:
        amounts = per_agent(s.receiver, amount, scope, w, s.event)
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


def per_agent(e: ir.Expr, amount: Value, scope: IterationScope, w: Writer, name: str) -> Value:
    """Returns what each agent gets in all: `[N]`, or a number if that is the same for all.

    name: of how often it gets the amount.
    """
    axis = w.axis("receiver", w.module.agents)
    many = math.prod(a.size for a in scope.axes) >= MANY and not amount.axes and axis.size <= 32
    if e.type.kind == "agents":
        members = w.value(e, scope)
        if many:
            return _counted(select(scope.mask, members, 0), amount, axis, scope, w, name)
        return _summed(scope.mask & in_set(members, axis), amount, scope.axes, w, name)
    who = agent(e, scope, w)
    if who.axis is not None:
        return _summed(scope.mask, amount, without(scope.axes, (who.axis,)), w, name)
    if many:
        return _counted(_alone(who, scope, w), amount, axis, scope, w, name)
    if scope.mask == TRUE or not who.index.axes:
        reached = scope.mask & one_hot(who.index, axis)
        return _summed(reached, amount, scope.axes, w, name)
    return _summed_by_agent(who.index, amount, axis, scope, w, name)


def _summed_by_agent(
    index: Value, amount: Value, axis: Axis, scope: IterationScope, w: Writer, name: str
) -> Value:
    """Returns what each agent gets in all from the instances, each of which names one."""
    is_same = not any(a in amount.axes for a in scope.axes)
    amounts = scope.mask if is_same else select(scope.mask, amount, 0)
    axes = axes_of(index, amounts)
    node = call("segment_sum", spread(amounts, axes), spread(index, axes), axis.extent)
    alike = literal(math.prod(a.size for a in scope.axes if a not in axes), "i32")
    if is_same:
        return _times(_times(alike, w.keep(name, Value(node, "i32", (axis,)))), amount)
    return _times(alike, Value(node, amount.dtype, (axis,)))


def _alone(who: AgentVar, scope: IterationScope, w: Writer) -> Value:
    """Returns an agent of each instance as a set of one, empty if the instance does not happen."""
    alone = who.alone
    if alone is not None and scope.mask in (
        alone.mask,
        w.keep("active", alone.mask),
    ):  # as it was made, or as a block has named it
        return alone.members
    dtype = w.module.set_dtype
    bit = scalar(Literal(1), dtype) << as_dtype(who.index, dtype).node
    one = alone.members if alone is not None else replace(who.index, node=bit, dtype=dtype)
    return select(scope.mask, one, 0)


def _counted(
    sets: Value, amount: Value, axis: Axis, scope: IterationScope, w: Writer, name: str
) -> Value:
    """Returns an amount times the number of instances whose set an agent is in."""
    count = w.keep(name, Value(call("times_in", sets.node, axis.extent), "i32", (axis,)))
    alike = math.prod(a.size for a in scope.axes if a not in sets.axes)
    return _times(count, _times(literal(alike, "i32"), amount))


def _summed(reached: Value, amount: Value, over: tuple[Axis, ...], w: Writer, name: str) -> Value:
    """Returns the sum over the instances that are reached.

    Where all give the same, they are counted, which is cheaper than adding.
    """
    if reached == TRUE:
        return reduce("sum", amount, over)
    if over and not any(axis in amount.axes for axis in over):
        return _times(w.keep(name, reduce("sum", reached, over)), amount)
    return reduce("sum", select(reached, amount, 0), over)


def _times(count: Value, amount: Value) -> Value:
    if count == literal(1, "i32"):
        return amount
    return count if amount == literal(1, "i32") else as_dtype(count, amount.dtype) * amount

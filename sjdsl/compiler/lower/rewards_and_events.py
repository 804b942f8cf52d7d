"""Lowers `give` and `tally`: sums rewards and event counts over all instances of a statement.

    each agent on orchard { give apple to agent }  reward + jnp.where(on_orchard, params.apple, 0.0)

Who receives may also be a computed agent, a set of agents, or all of them. Where all instances give
the same amount, how often each agent gets it is counted, which is cheaper than adding amounts.
"""

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
    common,
    joined,
    literal,
    one_hot,
    reduce,
    select,
    size_of,
    spread,
    without,
)
from sjdsl.compiler.lower.condition_names import value_name
from sjdsl.compiler.lower.domains import agents_in_sets
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

MANY = 64  # instances from which on it pays to count agents by the bits of sets


def give(s: ir.Give, scope: IterationScope, w: Writer) -> None:
    """Writes `give amount to receiver`: adds to the rewards of this step."""
    amount = real(s.value, scope, w)
    amount_name = "" if isinstance(s.value, ir.Number) else value_name(s.value)
    count_name = f"num_{amount_name}" if amount_name else "times"
    if s.receiver is not None:
        deliver("reward", _received(s.receiver, amount, scope, w, count_name), w)
        return
    receives = scope.mask
    if s.but is not None:
        axis = w.axis("receiver", w.module.agents)
        is_left_out = one_hot(agent(s.but, scope, w).number, axis)
        receives = scope.mask & ~is_left_out
    deliver("reward", _summed(receives, amount, scope.axes, w, count_name), w)


def tally(s: ir.Tally, scope: IterationScope, w: Writer) -> None:
    """Writes `tally event[key] for receiver`: adds to the counts of this step."""
    event = event_named(w.game, s.event)
    attribute = f"event_{param_attribute(s.event)}"
    amount = literal(1, "i32")
    if s.amount is not None:
        amount = as_dtype(w.value(s.amount, scope), "i32")
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
            # All entries at once: one sum instead of an update for each.
            entries = w.axis("word", w.module.num_entries(event.by))
            inner = scope.when(one_hot(key, entries))
            counts = _received(s.receiver, amount, inner, w, s.event)
            # The key may be the same for all agents.
            rows = aligned(counts, (agents, entries))
            deliver(attribute, replace(counts, node=rows), w)
            return
    for entry in event.by.entries:
        place = as_dtype(w.module.entry(entry), key.dtype)
        _count(s, attribute, place.node, amount, scope.when(key.eq(place)), w)


def _count(
    s: ir.Tally,
    attribute: str,
    entry: Expression | None,
    amount: Value,
    scope: IterationScope,
    w: Writer,
) -> None:
    """Adds to an event's count, of the game or of each receiver. entry: of an event by words."""
    if s.receiver is not None:
        amounts = _received(s.receiver, amount, scope, w, s.event)
    else:
        amounts = _summed(scope.mask, amount, scope.axes, w, s.event)
    deliver(attribute, amounts, w, entry)


def deliver(attribute: str, amounts: Value, w: Writer, entry: Expression | None = None) -> None:
    """Adds to an attribute of the outcome, or to one entry of its last axis."""
    if amounts.literal and not amounts.number:
        return
    before = w.total(attribute)
    if entry is None:
        w.accumulate(attribute, joined("+", before, amounts.node))
    else:
        w.accumulate(attribute, call("add_to_entry", before, entry, amounts.node))


def _received(e: ir.Expr, amount: Value, scope: IterationScope, w: Writer, name: str) -> Value:
    """Returns what each agent gets from all instances: `[N]`, or a number if all get the same.

    Args:
      e: the agent, or the set of agents, that receives the amount in each instance.
      name: in generated code, of the number of times that each agent gets the amount.
    """
    axis = w.axis("receiver", w.module.agents)
    is_large = size_of(scope.axes) >= MANY
    by_bits = is_large and not amount.axes and axis.size <= 32
    if e.type.kind == "agents":
        members = w.value(e, scope)
        if by_bits:
            sets = select(scope.mask, members, 0)
            return _counted(sets, amount, axis, scope, w, name)
        receives = scope.mask & agents_in_sets(members, axis)
        return _summed(receives, amount, scope.axes, w, name)
    who = agent(e, scope, w)
    if who.axis is not None:
        others = without(scope.axes, (who.axis,))
        return _summed(scope.mask, amount, others, w, name)
    if by_bits:
        sets = _sets_of_one(who, scope, w)
        return _counted(sets, amount, axis, scope, w, name)
    if scope.mask == TRUE or not who.number.axes:
        receives = scope.mask & one_hot(who.number, axis)
        return _summed(receives, amount, scope.axes, w, name)
    return _summed_by_agent(who.number, amount, axis, scope, w, name)


def _summed_by_agent(
    receivers: Value, amount: Value, axis: Axis, scope: IterationScope, w: Writer, name: str
) -> Value:
    """Returns what each agent gets from all instances, each of which names one by its number."""
    is_same = not common(scope.axes, amount.axes)
    amounts = scope.mask if is_same else select(scope.mask, amount, 0)
    axes = axes_of(receivers, amounts)
    sums = call("segment_sum", spread(amounts, axes), spread(receivers, axes), axis.extent)
    repeated = _repetitions(scope, axes)
    if not is_same:
        return _times(repeated, Value(sums, amount.dtype, (axis,)))
    count = w.keep(name, Value(sums, "i32", (axis,)))
    return _times(repeated * count, amount)


def _repetitions(scope: IterationScope, axes: Axes) -> Value:
    """Returns how many instances there are for each entry of an array over some of their axes."""
    return literal(size_of(without(scope.axes, axes)), "i32")


def _sets_of_one(who: AgentVar, scope: IterationScope, w: Writer) -> Value:
    """Returns the agent of each instance as a set, empty if the instance doesn't happen."""
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
    """Returns what each agent gets if it gets the same amount from each set that it is in.

    sets: of each instance, as bits; amount: the same for all instances.
    """
    count = w.keep(name, Value(call("times_in", sets.node, axis.extent), "i32", (axis,)))
    return _times(count, _times(_repetitions(scope, sets.axes), amount))


def _summed(receives: Value, amount: Value, over: Axes, w: Writer, name: str) -> Value:
    """Returns the sum of the amounts along the axes `over`, where `receives` holds."""
    if receives == TRUE:
        return reduce("sum", amount, over)
    if over and not common(over, amount.axes):
        return _times(w.keep(name, reduce("sum", receives, over)), amount)
    return reduce("sum", select(receives, amount, 0), over)


def _times(count: Value, amount: Value) -> Value:
    return as_dtype(count, amount.dtype) * amount

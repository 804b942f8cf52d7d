"""Lowers `give` and `tally`: sums rewards and event counts over all instances of a statement."""

import math
from dataclasses import replace

from sjdsl.compiler import ir
from sjdsl.compiler.ir.names import param_attribute
from sjdsl.compiler.lower.axes import DTYPES, Axis, Value, aligned, as_dtype, binary, both, literal, reduce, select, wrapped
from sjdsl.compiler.lower.domains import in_set
from sjdsl.compiler.lower.expressions import lower, owner, real, to_words
from sjdsl.compiler.lower.scope import AgentVar, Frame, Writer, iota

MANY = 64  # instances from which on agents are counted by the bits of sets


def give(s: ir.Give, frame: Frame, w: Writer) -> None:
    """Adds to the rewards of this step."""
    amount = real(s.value, frame.always(), w)
    if s.receiver is not None:
        deliver("reward", "", per_agent(s.receiver, amount, frame, w), w)
        return
    reached = frame.mask
    if s.but is not None:
        giver = frame.variables[s.but.name]
        assert isinstance(giver, AgentVar)
        reached = both(frame.mask, binary("!=", giver.index, iota(w.axis("receiver", w.module.num_agents)), "bool"))
    deliver("reward", "", _summed(reached, amount, frame.axes, w), w)


def tally(s: ir.Tally, frame: Frame, w: Writer) -> None:
    """Counts an event."""
    event = next(e for e in w.module.game.events if e.name == s.event)
    attribute = f"event_{param_attribute(s.event)}"
    amount = literal(1, "i32") if s.amount is None else as_dtype(lower(s.amount, frame.always(), w), "i32")
    if s.word is None:
        _count(s, attribute, "", amount, frame, w)
        return
    key = to_words(lower(s.word, frame.always(), w), s.word.type.words, event.by)
    if key.literal:
        _count(s, attribute, key.text, amount, frame, w)
        return
    agents = _one_each(s.receiver, frame)
    if agents is not None:  # all columns at once: one sum instead of an update for each
        word = w.axis("word", len(event.by))
        here = frame.when(binary("==", key, iota(word, "u8"), "bool"))
        got = per_agent(s.receiver, amount, here, w)
        deliver(attribute, "", replace(got, text=aligned(got, (agents, word))), w)  # the word may be the same for all agents
        return
    for number in range(len(event.by)):  # the word differs from instance to instance: one column at a time
        here = frame.when(binary("==", key, literal(number, "u8"), "bool"))
        _count(s, attribute, str(number), amount, here, w)


def _count(s: ir.Tally, attribute: str, column: str, amount: Value, frame: Frame, w: Writer) -> None:
    if s.receiver is not None:
        deliver(attribute, f":, {column}" if column else "", per_agent(s.receiver, amount, frame, w), w)
    else:
        deliver(attribute, column, _summed(frame.mask, amount, frame.axes, w), w)


def _one_each(receiver: ir.Expr | None, frame: Frame) -> Axis | None:
    """Returns the axis of the agents if every instance has one of its own that receives."""
    who = frame.variables[receiver.name] if isinstance(receiver, ir.Member) else None
    return who.axis if isinstance(who, AgentVar) and who.axis is not None and frame.axes == (who.axis,) else None


def deliver(attribute: str, place: str, got: Value, w: Writer) -> None:
    """Adds to an attribute of the outcome, or to the entries of it at a place."""
    if got.literal and not float(got.text):
        return
    before = w.total(attribute)
    w.accumulate(attribute, f"{before}.at[{place}].add({got.text})" if place else f"{before} + {wrapped(got)}")


def per_agent(e: ir.Expr, amount: Value, frame: Frame, w: Writer) -> Value:
    """Returns what each agent gets in all: `[N]`, or a number if that is the same for all."""
    axis = w.axis("receiver", w.module.num_agents)
    many = math.prod(a.size for a in frame.axes) >= MANY and not amount.axes and axis.size <= 32
    if e.type.kind == "agents":
        members = lower(e, frame, w)
        if many:
            return _counted(members, amount, axis, frame, w)
        return _summed(both(frame.mask, in_set(members, axis)), amount, frame.axes, w)
    who = owner(e, frame, w)
    assert isinstance(who, AgentVar)
    if who.axis is not None:
        return _summed(frame.mask, amount, tuple(a for a in frame.axes if a != who.axis), w)
    if many:
        dtype = w.module.set_dtype
        bit = f"{DTYPES[dtype]}(1) << {as_dtype(who.index, dtype).text}"
        return _counted(replace(who.index, text=bit, dtype=dtype), amount, axis, frame, w)
    # Comparing with every agent is far cheaper than a scatter, which XLA makes one entry at a time on a CPU.
    return _summed(both(frame.mask, binary("==", who.index, iota(axis), "bool")), amount, frame.axes, w)


def _counted(sets: Value, amount: Value, axis: Axis, frame: Frame, w: Writer) -> Value:
    """Returns an amount that is the same for all, times how many of the sets of the instances an agent is in."""
    reached = select(frame.mask, sets, literal(0, sets.dtype))
    count = w.keep("times", Value(f"times_in({reached.text}, {axis.size})", "i32", (axis,)))
    alike = math.prod(a.size for a in frame.axes if a not in reached.axes)
    return _times(count, _times(literal(alike, "i32"), amount))


def _summed(reached: Value | None, amount: Value, over: tuple[Axis, ...], w: Writer) -> Value:
    """Returns the sum over the instances that are reached; where all give the same, they are counted, which is cheaper than adding."""
    if reached is None:
        return reduce("sum", amount, over)
    if over and not any(axis in amount.axes for axis in over):
        return _times(w.keep("times", reduce("sum", reached, over)), amount)
    return reduce("sum", select(reached, amount, literal(0, amount.dtype)), over)


def _times(count: Value, amount: Value) -> Value:
    one = literal(1, "i32")
    return amount if count == one else count if amount == one else binary("*", as_dtype(count, amount.dtype), amount, amount.dtype)


__all__ = ["give", "tally"]

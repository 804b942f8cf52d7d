"""Sentences: each becomes lines that act on all its instances at once."""

from dataclasses import replace
from typing import assert_never

import numpy as np

from sjdsl.compiler import ir
from sjdsl.compiler.identifiers import param_attribute
from sjdsl.compiler.lower import reads
from sjdsl.compiler.lower.chosen import first, match_, pick
from sjdsl.compiler.lower.context import AgentVar, Frame, NotSupported, Writer, iota
from sjdsl.compiler.lower.domains import enter, sweep
from sjdsl.compiler.lower.draws import chances, draw
from sjdsl.compiler.lower.expressions import lower, owner, real, to_words
from sjdsl.compiler.lower.movement import move
from sjdsl.compiler.lower.sending import Sends
from sjdsl.compiler.lower.values import (
    Axis,
    Value,
    aligned,
    as_dtype,
    binary,
    both,
    invert,
    literal,
    reduce,
    select,
    union,
    wrapped,
)
from sjdsl.compiler.lower.writes import add, set_


def block(body: tuple[ir.Stmt, ...], frame: Frame, w: Writer, sends: Sends) -> None:
    """Writes the lines of a block; names bound in it end with it."""
    for s in body:
        w.origin = s.origin
        match s:
            case ir.Let():
                value = lower(s.value, frame.always(), w)
                frame = replace(frame, locals={**frame.locals, s.name: w.keep(s.name, value)})
            case ir.Draw():
                frame = replace(frame, locals={**frame.locals, s.name: draw(s, frame, w)})
            case _:
                sentence(s, frame, w, sends)


def sentence(s: ir.Stmt, frame: Frame, w: Writer, sends: Sends) -> None:
    match s:
        case ir.Each():
            _inside(s.body, enter(s.domain, frame, w), w, sends)
        case ir.Pick():
            inner, nobody = pick(s, frame, w)
            _inside(s.body, inner, w, sends)
            _inside(s.otherwise, frame.when(nobody), w, sends)
        case ir.First():
            inner, none = first(s, frame, w)
            _inside(s.body, inner, w, sends)
            _inside(s.otherwise, none, w, sends)
        case ir.Match():
            _inside(s.body, match_(s, frame, w), w, sends)
        case ir.When():
            when(s, frame, w, sends)
        case ir.Chance():
            happens, none = chances(s, frame, w)
            for branch, hit in zip(s.branches, happens, strict=True):
                _inside(branch.body, frame.when(hit), w, sends)
            _inside(s.otherwise, frame.when(none), w, sends)
        case ir.Set():
            set_(s, frame, w)
        case ir.Add():
            add(s, frame, w)
        case ir.Give():
            give(s, frame, w)
        case ir.Tally():
            tally(s, frame, w)
        case ir.Send():
            sends.add(s, frame, w)
        case ir.Remove():
            sends.remove(s, frame, w)
        case ir.Move():
            move(s, frame, w)
        case ir.Mark():
            mark(s, frame, w)
        case ir.End():
            active = active_mask(frame)
            w.accumulate("ended", f"{w.total('ended')} | {wrapped(reduce('any', active, active.axes))}")
        case ir.Let() | ir.Draw():
            raise AssertionError(s)
        case _:
            assert_never(s)


def _inside(body: tuple[ir.Stmt, ...], frame: Frame, w: Writer, sends: Sends) -> None:
    if not body or (frame.mask is not None and frame.mask.text == "False"):
        return
    if frame.mask is not None and len(body) + sum(len(getattr(s, "body", ())) for s in body) > 1:
        frame = replace(frame, mask=w.keep("active", frame.mask))
    block(body, frame, w, sends)


def active_mask(frame: Frame) -> Value:
    return frame.mask if frame.mask is not None else literal(True, "bool")


def when(s: ir.When, frame: Frame, w: Writer, sends: Sends) -> None:
    """Branches in order: each where its condition holds and none before it did."""
    rest = frame
    for branch in s.branches:
        test = lower(branch.test, frame.always(), w)
        if len(s.branches) > 1 or s.otherwise:
            test = w.keep("holds", test)
        _inside(branch.body, rest.when(test), w, sends)
        rest = rest.when(invert(test))
    _inside(s.otherwise, rest, w, sends)


def receivers(e: ir.Expr, frame: Frame, w: Writer) -> tuple[Value | None, Axis | None]:
    """Returns who is meant: ids (and no axis), or (for a set) which agents along a new axis."""
    if e.type.kind == "agents":
        axis = w.axis("receiver", w.module.num_agents)
        bits = lower(e, frame, w)
        shifted = binary(">>", bits, iota(axis, bits.dtype), bits.dtype)
        one = binary("&", shifted, literal(1, bits.dtype), bits.dtype)
        return binary("!=", one, literal(0, bits.dtype), "bool"), axis
    who = owner(e, frame, w)
    assert isinstance(who, AgentVar)
    return who.index, None


def per_agent(e: ir.Expr, amount: Value, frame: Frame, w: Writer) -> Value | tuple[Value, Value]:
    """Returns what each agent gets in all, `[N]`, or (ids, amounts) to be scattered."""
    if e.type.kind != "agents":
        who = owner(e, frame, w)
        assert isinstance(who, AgentVar)
        amount = select(frame.mask, amount, literal(0, amount.dtype)) if amount.text != "0" else amount
        if who.axis is not None:
            over = tuple(a for a in frame.axes if a != who.axis)
            return reduce("sum", amount, over)
        others = tuple(a for a in frame.axes if a not in who.index.axes)
        return who.index, reduce("sum", amount, others)
    mine, axis = receivers(e, frame, w)
    assert mine is not None and axis is not None
    masked = select(both(frame.mask, mine), amount, literal(0, amount.dtype))
    return reduce("sum", masked, frame.axes)


def deliver(attribute: str, column: str, got: Value | tuple[Value, Value], w: Writer) -> None:
    """Adds to an `[N]` attribute of the outcome (or one column of `[N, words]`)."""
    before = w.total(attribute)
    if isinstance(got, tuple):
        ids, amount = got
        axes = union(ids.axes, amount.axes)
        index = aligned(ids, axes) if ids.axes != axes else ids.text
        shape = ", ".join(str(a.size) for a in axes)
        values = aligned(amount, axes) if amount.axes else amount.text
        if index != ids.text or (amount.axes and amount.axes != axes):
            index = f"jnp.broadcast_to({index}, ({shape},))"
        w.accumulate(attribute, f'{before}.at[{index}{column}].add({values}, mode="drop")')
    elif column:
        w.accumulate(attribute, f"{before}.at[:{column}].add({got.text})")
    else:
        w.accumulate(attribute, f"{before} + {wrapped(got)}")


def give(s: ir.Give, frame: Frame, w: Writer) -> None:
    """Adds to the rewards of this step."""
    value = real(s.value, frame.always(), w)
    if s.receiver is not None:
        deliver("reward", "", per_agent(s.receiver, value, frame, w), w)
        return
    masked = select(frame.mask, value, literal(0, "f32"))
    if s.but is None:
        deliver("reward", "", reduce("sum", masked, frame.axes), w)
        return
    giver = frame.variables[s.but.name]
    assert isinstance(giver, AgentVar)
    axis = w.axis("receiver", w.module.num_agents)
    other = binary("!=", giver.index, iota(axis), "bool")
    shared = select(both(frame.mask, other), value, literal(0, "f32"))
    deliver("reward", "", reduce("sum", shared, frame.axes), w)


def tally(s: ir.Tally, frame: Frame, w: Writer) -> None:
    """Counts an event."""
    event = next(e for e in w.module.game.events if e.name == s.event)
    attribute = f"event_{param_attribute(s.event)}"
    amount = literal(1, "i32") if s.amount is None else as_dtype(lower(s.amount, frame.always(), w), "i32")
    if s.word is not None:
        key = to_words(lower(s.word, frame.always(), w), s.word.type.words, event.by)
        if not key.literal:
            _tally_by_word(s, attribute, key, amount, event, frame, w)
            return
        column = f", {key.text}"
    else:
        column = ""
    if s.receiver is None:
        total = reduce("sum", select(frame.mask, amount, literal(0, "i32")), frame.axes)
        text = f"{w.total(attribute)} + {wrapped(total)}" if not column else f"{w.total(attribute)}.at[{column[2:]}].add({total.text})"
        w.accumulate(attribute, text)
        return
    plain = frame.mask is not None and amount.text == "1" and s.receiver.type.kind != "agents"
    if plain:
        got = per_agent_count(s.receiver, frame, w)
    else:
        got = per_agent(s.receiver, amount, frame, w)
    deliver(attribute, column, got, w)


def per_agent_count(e: ir.Expr, frame: Frame, w: Writer) -> Value | tuple[Value, Value]:
    """Returns how many instances each agent has: the mask itself, summed."""
    who = owner(e, frame, w)
    assert isinstance(who, AgentVar) and frame.mask is not None
    if who.axis is not None:
        return reduce("sum", frame.mask, tuple(a for a in frame.axes if a != who.axis))
    return who.index, reduce("sum", frame.mask, tuple(a for a in frame.axes if a not in who.index.axes))


def _tally_by_word(s: ir.Tally, attribute: str, key: Value, amount: Value, event: ir.Event, frame: Frame, w: Writer) -> None:
    """The word differs from instance to instance: one column at a time."""
    for number in range(len(event.by)):
        here = frame.when(binary("==", key, literal(number, "u8"), "bool"))
        if s.receiver is None:
            total = reduce("sum", select(here.mask, amount, literal(0, "i32")), here.axes)
            w.accumulate(attribute, f"{w.total(attribute)}.at[{number}].add({total.text})")
        else:
            deliver(attribute, f", {number}", per_agent(s.receiver, amount, here, w), w)


def mark(s: ir.Mark, frame: Frame, w: Writer) -> None:
    """Keeps the cells to be shown in the next observation; 0 stands for none."""
    if frame.variables[s.anchor.name].axis is None or not isinstance(frame.variables[s.anchor.name], AgentVar):
        raise NotSupported("`mark` around anything but an agent of an `each`", s.origin)
    place = ir.Near(shape=s.shape, anchor=s.anchor)
    swept = sweep(place, frame, w)
    over = tuple(a for a in frame.axes if a not in swept.cells.axes)
    happens = None if frame.mask is None else reduce("any", frame.mask, over)
    ok = both(happens, swept.ok)
    cells = select(ok, swept.cells, literal(0, "i32"))
    w.marked[w.keep("marked", Value(f"{wrapped(cells)}.reshape(-1)", "i32")).text] = mark_size(s, w.module.game)


def mark_size(rules: ir.Node, game: ir.Game) -> int:
    """Returns how many cells a phase or a sentence can mark."""
    size = 0
    shapes = {s.name: s for s in game.shapes}
    for node in ir.walk(rules):
        if isinstance(node, ir.Mark):
            size += game.agents.number * sum(map(len, shapes[node.shape].lanes))
    return size


__all__ = ["block", "mark_size", "np", "reads"]

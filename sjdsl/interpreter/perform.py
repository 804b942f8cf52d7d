"""Interprets statements: each one adds its writes to those of its phase, in one instance."""

from typing import assert_never

import numpy as np

from sjdsl.compiler import ir
from sjdsl.interpreter import chances, members
from sjdsl.interpreter.account import Drawn
from sjdsl.interpreter.evaluate import agents_in, cells_in, evaluate, members_of, nearest_members
from sjdsl.interpreter.instance import Instance
from sjdsl.interpreter.overflow import LeavesFloat32
from sjdsl.interpreter.writes import Counted, Sending, Writes, slots


def perform(body: tuple[ir.Stmt, ...], here: Instance, writes: Writes) -> None:
    """Collects the writes of a block; a name bound by `let` or `draw` holds to the end of it. Raises LeavesFloat32."""
    for sentence in body:
        try:
            here = _performed(sentence, here, writes)
        except FloatingPointError:
            raise LeavesFloat32(sentence, here.world.step) from None


def _performed(sentence: ir.Stmt, here: Instance, writes: Writes) -> Instance:
    """Collects the writes of one sentence; returns the instance in which those after it stand."""
    match sentence:
        case ir.Let():
            return here.binding({sentence.name: evaluate(sentence.value, here)})
        case ir.Draw():
            drawn = _noted(chances.draw(sentence, here), writes)
            return here.binding({sentence.name: drawn.result}).because(drawn)
        case _:
            before = writes.sizes()
            _sentence(sentence, here, writes)
            writes.tell(sentence, here, before)
            return here


def _sentence(
    sentence: "ir.Each | ir.Pick | ir.First | ir.Match | ir.When | ir.Chance | ir.Set | ir.Add | ir.Give | ir.Tally"
    " | ir.Send | ir.Remove | ir.Move | ir.Mark | ir.End",
    here: Instance,
    writes: Writes,
) -> None:
    match sentence:
        case ir.Each():
            for member in members_of(sentence.domain, here):
                _inside(sentence.body, sentence.domain, member, here, writes)
        case ir.Pick():
            _pick(sentence, here, writes)
        case ir.First():
            _first(sentence, here, writes)
        case ir.Match():
            for left, right, drawn in chances.matched(sentence, here):
                if _noted(drawn, writes).result:
                    _inside(sentence.body, sentence.left, left, here.binding(right.names).because(drawn), writes)
        case ir.When():
            holding = [b.body for b in sentence.branches if evaluate(b.test, here)][:1]
            perform(holding[0] if holding else sentence.otherwise, here, writes)
        case ir.Chance():
            drawn = _noted(chances.chance(sentence, here), writes)
            body = sentence.otherwise if drawn.result is None else sentence.branches[drawn.result].body
            perform(body, here.because(drawn), writes)
        case ir.Set():
            writes.sets += slots(sentence.target, evaluate(sentence.value, here), here)
        case ir.Add():
            writes.adds += slots(sentence.target, evaluate(sentence.value, here), here)
        case ir.Give():
            _give(sentence, here, writes)
        case ir.Tally():
            _tally(sentence, here, writes)
        case ir.Send():
            _send(sentence, here, writes)
        case ir.Remove():
            writes.removes |= set(agents_in(evaluate(sentence.who, here)))
        case ir.Move():
            _move(sentence, here, writes)
        case ir.Mark():
            near = ir.Near(shape=sentence.shape, anchor=sentence.anchor)
            writes.marks |= set(cells_in(near, here))
        case ir.End():
            writes.end = True
        case _:
            assert_never(sentence)


def _noted(drawn: Drawn, writes: Writes) -> Drawn:
    if writes.drawn is not None:
        writes.drawn.append(drawn)
    return drawn


def _inside(body: tuple[ir.Stmt, ...], domain: ir.Domain, member: members.Found, here: Instance, writes: Writes) -> None:
    perform(body, here.inside(member.names, member.number, members.radix(domain, here.board)), writes)


def _pick(sentence: ir.Pick, here: Instance, writes: Writes) -> None:
    all_members = members_of(sentence.domain, here)
    if not all_members:
        perform(sentence.otherwise, here, writes)
    for member, drawn in chances.picked(sentence, all_members, here):
        _inside(sentence.body, sentence.domain, member, here.because(_noted(drawn, writes)), writes)


def _first(sentence: ir.First, here: Instance, writes: Writes) -> None:
    by_lane = nearest_members(sentence.domain, here)
    for lane, member in enumerate(by_lane):
        if member is None:
            perform(sentence.otherwise, here.inside({}, lane, len(by_lane)), writes)
        else:
            perform(sentence.body, here.inside(member.names, lane, len(by_lane)), writes)


def _give(sentence: ir.Give, here: Instance, writes: Writes) -> None:
    value = np.float32(evaluate(sentence.value, here))
    if sentence.receiver is None:
        receivers = set(range(here.board.agents))
    else:
        receivers = set(agents_in(evaluate(sentence.receiver, here)))
    if sentence.but is not None:
        receivers -= {here.names[sentence.but.name]}
    writes.gives += [(agent, value) for agent in sorted(receivers)]


def _tally(sentence: ir.Tally, here: Instance, writes: Writes) -> None:
    word = None if sentence.word is None else evaluate(sentence.word, here)
    amount = 1 if sentence.amount is None else evaluate(sentence.amount, here)
    receivers = [None] if sentence.receiver is None else sorted(agents_in(evaluate(sentence.receiver, here)))
    writes.tallies += [Counted(sentence.event, word, agent, amount) for agent in receivers]


def _send(sentence: ir.Send, here: Instance, writes: Writes) -> None:
    ticks = 0 if sentence.after is None else evaluate(sentence.after, here)
    for agent in agents_in(evaluate(sentence.who, here)):
        sending = Sending(agent, sentence, ticks)
        others = [s for s in writes.sends if s.agent == agent]
        assert all(_is_same(sending, s) for s in others), f"agent {agent} is sent to two places"
        if not others:
            writes.sends.append(sending)


def _is_same(a: Sending, b: Sending) -> bool:
    return (a.ticks, a.send.pool, a.send.facing, a.send.stay) == (b.ticks, b.send.pool, b.send.facing, b.send.stay)


def _move(sentence: ir.Move, here: Instance, writes: Writes) -> None:
    assert writes.movers is None, "two `move` in one phase"
    writes.movers = {}
    radix = members.radix(sentence.domain, here.board)
    for member in members_of(sentence.domain, here):
        word = here.word(sentence.stream, here.number * radix + member.number)
        writes.movers[member.number] = (word & ~0xFF) | member.number

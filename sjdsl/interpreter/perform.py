"""Interprets statements: each one adds its writes to those of its phase, in one instance."""

from typing import assert_never

import numpy as np

from sjdsl.compiler import ir
from sjdsl.compiler.ir.free_variables import variables_around
from sjdsl.interpreter import chances, members
from sjdsl.interpreter.account import Drawn
from sjdsl.interpreter.evaluate import cells_in, evaluate, members_of, nearest_members
from sjdsl.interpreter.evaluation_parts import agents_in
from sjdsl.interpreter.instance import Instance
from sjdsl.interpreter.movement import course_of
from sjdsl.interpreter.overflow import LeavesFloat32
from sjdsl.interpreter.shifting import shifting
from sjdsl.interpreter.state import Cell, Mover
from sjdsl.interpreter.writes import Counted, Lot, Sending, Writes, slots


def perform(body: tuple[ir.Stmt, ...], here: Instance, writes: Writes) -> None:
    """Collects the writes of a block; a name bound by `let` or `draw` holds to the end of it. Raises LeavesFloat32."""
    for statement in body:
        try:
            here = _performed(statement, here, writes)
        except FloatingPointError:
            raise LeavesFloat32(statement, here.world.step) from None


def _performed(statement: ir.Stmt, here: Instance, writes: Writes) -> Instance:
    """Collects the writes of one statement; returns the instance in which those after it stand."""
    match statement:
        case ir.Let():
            return here.binding({statement.name: evaluate(statement.value, here)})
        case ir.Draw():
            drawn = _noted(chances.draw(statement, here), writes)
            return here.binding({statement.name: drawn.result}).because(drawn)
        case _:
            before = writes.sizes()
            _statement(statement, here, writes)
            writes.tell(statement, here, before)
            return here


def _statement(
    statement: "ir.Each | ir.Pick | ir.First | ir.Match | ir.When | ir.Chance | ir.Set | ir.Add | ir.Give | ir.Tally"
    " | ir.Send | ir.Shift | ir.Remove | ir.Move | ir.Mark | ir.End",
    here: Instance,
    writes: Writes,
) -> None:
    match statement:
        case ir.Each():
            for member in members_of(statement.domain, here):
                _inside(statement.body, statement.domain, member, here, writes)
        case ir.Pick():
            _pick(statement, here, writes)
        case ir.First():
            _first(statement, here, writes)
        case ir.Match():
            for left, right, drawn in chances.matched(statement, here):
                if _noted(drawn, writes).result:
                    _inside(statement.body, statement.left, left, here.binding(right.names).because(drawn), writes)
        case ir.When():
            holding = next((b.body for b in statement.branches if evaluate(b.test, here)), statement.otherwise)
            perform(holding, here, writes)
        case ir.Chance():
            drawn = _noted(chances.chance(statement, here), writes)
            body = statement.otherwise if drawn.result is None else statement.branches[drawn.result].body
            perform(body, here.because(drawn), writes)
        case ir.Set(lot=int(stream)):
            rank, place = here.word(stream, here.number) >> 1, (statement.origin.start if statement.origin else 0, here.number)
            writes.lots += [Lot(*pair, rank, place) for pair in slots(statement.target, evaluate(statement.value, here), here)]
        case ir.Set():
            writes.sets += slots(statement.target, evaluate(statement.value, here), here)
        case ir.Add():
            writes.adds += slots(statement.target, evaluate(statement.value, here), here)
        case ir.Give():
            _give(statement, here, writes)
        case ir.Tally():
            _tally(statement, here, writes)
        case ir.Send():
            _send(statement, here, writes)
        case ir.Shift():
            _shift(statement, here, writes)
        case ir.Remove():
            writes.removes |= set(agents_in(evaluate(statement.who, here)))
        case ir.Move():
            _move(statement, here, writes)
        case ir.Mark():
            near = ir.Near(shape=statement.shape, anchor=statement.anchor)
            writes.marks |= set(cells_in(near, here))
        case ir.End():
            writes.end = True
        case _:
            assert_never(statement)


def _noted(drawn: Drawn, writes: Writes) -> Drawn:
    if writes.drawn is not None:
        writes.drawn.append(drawn)
    return drawn


def _inside(body: tuple[ir.Stmt, ...], domain: ir.Domain, member: members.Found, here: Instance, writes: Writes) -> None:
    perform(body, here.inside(member.names, member.number, members.radix(domain, here.board)), writes)


def _pick(statement: ir.Pick, here: Instance, writes: Writes) -> None:
    all_members = members_of(statement.domain, here)
    if not all_members:
        perform(statement.otherwise, here, writes)
    for member, drawn in chances.picked(statement, all_members, here):
        _inside(statement.body, statement.domain, member, here.because(_noted(drawn, writes)), writes)


def _first(statement: ir.First, here: Instance, writes: Writes) -> None:
    by_lane = nearest_members(statement.domain, here)
    for lane, member in enumerate(by_lane):
        if member is None:
            perform(statement.otherwise, here.inside({}, lane, len(by_lane)), writes)
        else:
            perform(statement.body, here.inside(member.names, lane, len(by_lane)), writes)


def _give(statement: ir.Give, here: Instance, writes: Writes) -> None:
    value = np.float32(evaluate(statement.value, here))
    if statement.receiver is None:
        receivers = set(range(here.board.agents))
    else:
        receivers = set(agents_in(evaluate(statement.receiver, here)))
    if statement.but is not None:
        receivers -= {here.names[statement.but.name]}
    writes.gives += [(agent, value) for agent in sorted(receivers)]


def _tally(statement: ir.Tally, here: Instance, writes: Writes) -> None:
    word = None if statement.word is None else evaluate(statement.word, here)
    amount = 1 if statement.amount is None else evaluate(statement.amount, here)
    receivers = [None] if statement.receiver is None else sorted(agents_in(evaluate(statement.receiver, here)))
    writes.tallies += [Counted(statement.event, word, agent, amount) for agent in receivers]


def _send(statement: ir.Send, here: Instance, writes: Writes) -> None:
    ticks = 0 if statement.after is None else evaluate(statement.after, here)
    for agent in agents_in(evaluate(statement.who, here)):
        sending = Sending(agent, statement, ticks, here.names)
        others = [s for s in writes.sends if s.agent == agent]
        assert all(_is_same(sending, s) for s in others), f"agent {agent} is sent to two places"
        if not others:
            writes.sends.append(sending)


def _shift(statement: ir.Shift, here: Instance, writes: Writes) -> None:
    for agent in agents_in(evaluate(statement.who, here)):
        sent = shifting(agent, statement, here)
        others = [s for s in writes.shifts if s.agent == agent]
        assert all((s.target, s.statement.facing) == (sent.target, statement.facing) for s in others), (
            f"agent {agent} is sent to two places"
        )
        if not others:
            writes.shifts.append(sent)


def _is_same(a: Sending, b: Sending) -> bool:
    said = [(s.ticks, s.send.pool, s.send.facing, s.send.stay, [s.names[v.name] for v in variables_around(s.send.domain)]) for s in (a, b)]
    return said[0] == said[1]


def _move(statement: ir.Move, here: Instance, writes: Writes) -> None:
    assert writes.movers is None, "two `move` in one phase"
    writes.movers, writes.sort = {}, statement.domain.var.sort
    radix = members.radix(statement.domain, here.board)
    for found in members_of(statement.domain, here):
        word = here.word(statement.stream, here.number * radix + found.number)
        assert not isinstance(found.member, Cell)
        writes.movers[found.member] = (word & ~0xFF) | found.number
        if statement.course is not None and isinstance(found.member, Mover):
            writes.courses[found.member] = course_of(statement.course, found.member, here.binding(found.names))

"""Interprets statements: each one adds its writes to those of its phase, in one instance."""

from typing import Any, assert_never

import numpy as np

from sjdsl.compiler import ir
from sjdsl.compiler.ir.free_variables import variables_around
from sjdsl.interpreter import chances, members
from sjdsl.interpreter.account import Drawn
from sjdsl.interpreter.evaluate import agents_in, cells_in, evaluate, members_of, nearest_members
from sjdsl.interpreter.instance import Instance
from sjdsl.interpreter.movement import course_of
from sjdsl.interpreter.overflow import LeavesFloat32
from sjdsl.interpreter.shifting import shifting
from sjdsl.interpreter.state import Cell, Mover
from sjdsl.interpreter.writes import Counted, Lot, Sending, Shifting, Writes, slots


def perform(body: tuple[ir.Stmt, ...], here: Instance, writes: Writes) -> None:
    """Collects the writes of a block; a name bound by `let` or `draw` holds to the end of it. Raises LeavesFloat32."""
    for statement in body:
        try:
            match statement:
                case ir.Let():
                    here = here.binding({statement.name: evaluate(statement.value, here)})
                case ir.Draw():
                    drawn = _noted(chances.draw(statement, here), writes)
                    here = here.binding({statement.name: drawn.result}).because(drawn)
                case _:
                    before = writes.sizes()
                    _statement(statement, here, writes)
                    writes.tell(statement, here, before)
        except FloatingPointError:
            raise LeavesFloat32(statement, here.world.step) from None


def _statement(statement: ir.Stmt, here: Instance, writes: Writes) -> None:
    match statement:
        case ir.Each():
            for member in members_of(statement.domain, here):
                _inside(statement.body, statement.domain, member, here, writes)
        case ir.Pick():
            candidates = members_of(statement.domain, here)
            if not candidates:
                perform(statement.otherwise, here, writes)
            for member, drawn in chances.picked(statement, candidates, here):
                _inside(
                    statement.body,
                    statement.domain,
                    member,
                    here.because(_noted(drawn, writes)),
                    writes,
                )
        case ir.First():
            by_lane = nearest_members(statement.domain, here)
            for lane, nearest in enumerate(by_lane):
                if nearest is not None:
                    perform(statement.body, here.inside(nearest.names, lane, len(by_lane)), writes)
        case ir.Match():
            for left, right, drawn in chances.matched(statement, here):
                if _noted(drawn, writes).result:
                    _inside(
                        statement.body,
                        statement.left,
                        left,
                        here.binding(right.names).because(drawn),
                        writes,
                    )
        case ir.When():
            holding = next(
                (b.body for b in statement.branches if evaluate(b.test, here)), statement.otherwise
            )
            perform(holding, here, writes)
        case ir.Chance():
            drawn = _noted(chances.chance(statement, here), writes)
            body = (
                statement.otherwise
                if drawn.result is None
                else statement.branches[drawn.result].body
            )
            perform(body, here.because(drawn), writes)
        case ir.Set(lot=int(stream)):
            rank, place = (
                here.word(stream, here.number) >> 1,
                (statement.origin.start if statement.origin else 0, here.number),
            )
            writes.lots += [
                Lot(*pair, rank, place)
                for pair in slots(statement.target, evaluate(statement.value, here), here)
            ]
        case ir.Set():
            writes.sets += slots(statement.target, evaluate(statement.value, here), here)
        case ir.Add():
            writes.adds += slots(statement.target, evaluate(statement.value, here), here)
        case ir.Give():
            _give(statement, here, writes)
        case ir.Tally():
            word = None if statement.word is None else evaluate(statement.word, here)
            amount = 1 if statement.amount is None else evaluate(statement.amount, here)
            receivers = (
                [None]
                if statement.receiver is None
                else sorted(agents_in(evaluate(statement.receiver, here)))
            )
            writes.tallies += [Counted(statement.event, word, agent, amount) for agent in receivers]
        case ir.Send() | ir.Shift():
            _send(statement, here, writes)
        case ir.Remove():
            writes.removes |= set(agents_in(evaluate(statement.who, here)))
        case ir.Move():
            _move(statement, here, writes)
        case ir.Mark():
            near = ir.Near(shape=statement.shape, anchor=statement.anchor)
            writes.marks |= set(cells_in(near, here))
        case ir.End():
            writes.end = True
        case ir.Let() | ir.Draw():
            raise AssertionError(statement)
        case _:
            assert_never(statement)


def _noted(drawn: Drawn, writes: Writes) -> Drawn:
    if writes.drawn is not None:
        writes.drawn.append(drawn)
    return drawn


def _inside(
    body: tuple[ir.Stmt, ...],
    domain: ir.Domain,
    member: members.Found,
    here: Instance,
    writes: Writes,
) -> None:
    perform(
        body, here.inside(member.names, member.number, members.radix(domain, here.board)), writes
    )


def _give(statement: ir.Give, here: Instance, writes: Writes) -> None:
    value = np.float32(evaluate(statement.value, here))
    everybody = range(here.board.agents)
    receivers = set(
        everybody if statement.receiver is None else agents_in(evaluate(statement.receiver, here))
    )
    but = set() if statement.but is None else {here.names[statement.but.name]}
    writes.gives += [(agent, value) for agent in sorted(receivers - but)]


def _send(statement: ir.Send | ir.Shift, here: Instance, writes: Writes) -> None:
    """Notes where those are sent whom the statement names; of several who send one, all say the same."""
    ticks = (
        evaluate(statement.after, here)
        if isinstance(statement, ir.Send) and statement.after is not None
        else 0
    )
    for agent in agents_in(evaluate(statement.who, here)):
        sends: list[Any] = writes.sends if isinstance(statement, ir.Send) else writes.shifts
        sent: Sending | Shifting
        sent = (
            Sending(agent, statement, ticks, here.names)
            if isinstance(statement, ir.Send)
            else shifting(agent, statement, here)
        )
        others = [s for s in sends if s.agent == agent]
        assert all(_destination(s) == _destination(sent) for s in others), (
            f"agent {agent} is sent to two places"
        )
        if not others:
            sends.append(sent)


def _destination(sent: Sending | Shifting) -> tuple[object, ...]:
    """Returns all that is said of where, when and how somebody is sent."""
    if isinstance(sent, Shifting):
        return sent.target, sent.statement.facing
    s = sent.send
    return (
        sent.ticks,
        s.pool,
        s.facing,
        s.stay,
        [sent.names[v.name] for v in variables_around(s.domain)],
    )


def _move(statement: ir.Move, here: Instance, writes: Writes) -> None:
    assert writes.movers is None, "two `move` in one phase"
    writes.movers, writes.sort = {}, statement.domain.var.sort
    radix = members.radix(statement.domain, here.board)
    for found in members_of(statement.domain, here):
        word = here.word(statement.stream, here.number * radix + found.number)
        assert not isinstance(found.member, Cell)
        writes.movers[found.member] = (word & ~0xFF) | found.number
        if statement.course is not None and isinstance(found.member, Mover):
            writes.courses[found.member] = course_of(
                statement.course, found.member, here.binding(found.names)
            )

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
from sjdsl.interpreter.sending import facing_of
from sjdsl.interpreter.shifting import make_shifting
from sjdsl.interpreter.state import Cell, Mover
from sjdsl.interpreter.writes import Counted, Lot, Sending, Shifting, Writes, slots


def perform(body: tuple[ir.Stmt, ...], instance: Instance, writes: Writes) -> None:
    """Collects the writes of a block. Raises LeavesFloat32.

    A name bound by `let` or `draw` is valid to the end of the block.
    """
    for statement in body:
        try:
            match statement:
                case ir.Let():
                    instance = instance.binding(
                        {statement.name: evaluate(statement.value, instance)}
                    )
                case ir.Draw():
                    drawn = chances.draw_value(statement, instance)
                    _record(drawn, writes)
                    instance = instance.binding({statement.name: drawn.result}).because(drawn)
                case _:
                    sizes = writes.sizes()
                    _perform_statement(statement, instance, writes)
                    writes.record(statement, instance, sizes)
        except FloatingPointError:
            raise LeavesFloat32(statement, instance.world.step) from None


def _perform_statement(statement: ir.Stmt, instance: Instance, writes: Writes) -> None:
    """Collects the writes of one statement."""
    match statement:
        case ir.Each():
            for member in members_of(statement.domain, instance):
                _perform_for(statement.body, statement.domain, member, instance, writes)
        case ir.Pick():
            candidates = members_of(statement.domain, instance)
            if not candidates:
                perform(statement.otherwise, instance, writes)
            for member, drawn in chances.pick_members(statement, candidates, instance):
                _record(drawn, writes)
                outer = instance.because(drawn)
                _perform_for(statement.body, statement.domain, member, outer, writes)
        case ir.First():
            nearest = nearest_members(statement.domain, instance)
            for lane, first in enumerate(nearest):
                if first is not None:
                    inner = instance.for_member(first.names, lane, len(nearest))
                    perform(statement.body, inner, writes)
        case ir.Match():
            for left, right, drawn in chances.match_pairs(statement, instance):
                _record(drawn, writes)
                if drawn.result:
                    outer = instance.binding(right.names).because(drawn)
                    _perform_for(statement.body, statement.left, left, outer, writes)
        case ir.When():
            bodies = (
                branch.body for branch in statement.branches if evaluate(branch.test, instance)
            )
            perform(next(bodies, statement.otherwise), instance, writes)
        case ir.Chance():
            drawn = chances.choose_branch(statement, instance)
            _record(drawn, writes)
            body = statement.otherwise
            if drawn.result is not None:
                body = statement.branches[drawn.result].body
            perform(body, instance.because(drawn), writes)
        case ir.Set(lot=int(stream)):
            rank = instance.bits(stream, instance.number) >> 1
            source_position = statement.origin.start if statement.origin else 0
            place = (source_position, instance.number)
            value = evaluate(statement.value, instance)
            for slot, entry in slots(statement.target, value, instance):
                writes.lots.append(Lot(slot, entry, rank, place))
        case ir.Set():
            writes.sets += slots(statement.target, evaluate(statement.value, instance), instance)
        case ir.Add():
            writes.adds += slots(statement.target, evaluate(statement.value, instance), instance)
        case ir.Give():
            _give(statement, instance, writes)
        case ir.Tally():
            key = None if statement.word is None else evaluate(statement.word, instance)
            amount = 1 if statement.amount is None else evaluate(statement.amount, instance)
            agents: list[int | None] = [None]
            if statement.receiver is not None:
                agents = [*sorted(agents_in(evaluate(statement.receiver, instance)))]
            writes.tallies += [Counted(statement.event, key, agent, amount) for agent in agents]
        case ir.Send() | ir.Shift():
            _send(statement, instance, writes)
        case ir.Face():
            heading = evaluate(statement.heading, instance)
            who = agents_in(evaluate(statement.who, instance))
            writes.turns += [(agent, heading) for agent in who]
        case ir.Remove():
            writes.removes |= set(agents_in(evaluate(statement.who, instance)))
        case ir.Move():
            _move(statement, instance, writes)
        case ir.Mark():
            near = ir.Near(shape=statement.shape, anchor=statement.anchor)
            writes.marks |= set(cells_in(near, instance))
        case ir.End():
            writes.end = True
        case ir.Let() | ir.Draw():
            raise AssertionError(statement)
        case _:
            assert_never(statement)


def _record(drawn: Drawn, writes: Writes) -> None:
    """Adds a draw to the account of the phase, if there is one."""
    if writes.drawn is not None:
        writes.drawn.append(drawn)


def _perform_for(
    body: tuple[ir.Stmt, ...],
    domain: ir.Domain,
    member: members.Bound,
    instance: Instance,
    writes: Writes,
) -> None:
    """Performs a block for one member of a domain."""
    radix = members.radix(domain, instance.board)
    perform(body, instance.for_member(member.names, member.number, radix), writes)


def _give(statement: ir.Give, instance: Instance, writes: Writes) -> None:
    """Collects the rewards of a statement; without a receiver, all agents get it."""
    value = np.float32(evaluate(statement.value, instance))
    receivers = set(range(instance.board.agents))
    if statement.receiver is not None:
        receivers = set(agents_in(evaluate(statement.receiver, instance)))
    if statement.but is not None:
        receivers.discard(instance.names[statement.but.name])
    writes.gives += [(agent, value) for agent in sorted(receivers)]


def _send(statement: ir.Send | ir.Shift, instance: Instance, writes: Writes) -> None:
    """Collects where agents or movers are sent.

    Several statements may only send one of them to the same place.
    """
    agents = agents_in(evaluate(statement.who, instance))
    if isinstance(statement, ir.Shift):
        for agent in agents:
            _add_sent(make_shifting(agent, statement, instance), writes.shifts)
        return
    ticks = 0 if statement.after is None else evaluate(statement.after, instance)
    facing = facing_of(statement, instance)
    for agent in agents:
        _add_sent(Sending(agent, statement, ticks, facing, instance.names), writes.sends)


def _add_sent(sent: Any, collected: list[Any]) -> None:
    """Adds a `Sending` or `Shifting` to a list of the same class, unless it is there already."""
    others = [other for other in collected if other.agent == sent.agent]
    assert all(_destination(other) == _destination(sent) for other in others), (
        f"agent {sent.agent} is sent to two places"
    )
    if not others:
        collected.append(sent)


def _destination(sent: Sending | Shifting) -> tuple[object, ...]:
    """Returns where, when and how a body is sent, as far as statements can differ in it."""
    if isinstance(sent, Shifting):
        return sent.target, sent.facing
    send = sent.send
    values = [sent.names[variable.name] for variable in variables_around(send.domain)]
    return sent.ticks, send.pool, sent.facing, send.stay, values


def _move(statement: ir.Move, instance: Instance, writes: Writes) -> None:
    """Collects who moves, with their ranks, and the courses of movers."""
    assert writes.movers is None, "two `move` in one phase"
    writes.movers = {}
    writes.entity_type = statement.domain.var.entity_type
    radix = members.radix(statement.domain, instance.board)
    for bound in members_of(statement.domain, instance):
        body = bound.member
        assert not isinstance(body, Cell)
        bits = instance.bits(statement.stream, instance.number * radix + bound.number)
        # The number, which is below 256, decides between equal random bits.
        writes.movers[body] = (bits & ~0xFF) | bound.number
        if statement.course is not None and isinstance(body, Mover):
            inner = instance.binding(bound.names)
            writes.courses[body] = course_of(statement.course, body, inner)

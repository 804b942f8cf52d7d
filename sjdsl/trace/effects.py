"""The effects of one turn of the schedule: each change, with the statements that caused it."""

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

from sjdsl.compiler import ir
from sjdsl.interpreter.account import Account, Done
from sjdsl.interpreter.board import Board
from sjdsl.interpreter.bodies import (
    Body,
    away_of,
    bodies,
    heading_of,
    herd_of,
    number_of,
    type_of_body,
    where_is,
)
from sjdsl.interpreter.evaluate import agents_in, cells_in, evaluate
from sjdsl.interpreter.instance import Instance
from sjdsl.interpreter.state import Cell, Mover, Value
from sjdsl.interpreter.stored import held_values
from sjdsl.interpreter.threefry import return_stream
from sjdsl.interpreter.writes import Slot, winners

Changed = Literal["field", "place", "heading", "away", "moved", "reward", "event", "mark", "end"]
Owner = int | Mover | Cell | None
Purpose = Literal["which cell", "which heading", "which way"]
RandomNumbers = Mapping[tuple[int, int], int]  # (stream, number) -> 32 random bits


class Used(NamedTuple):
    """A random number that decided where an agent or a mover went."""

    purpose: Purpose
    stream: int
    number: int
    bits: int


@dataclass(frozen=True)
class Effect:
    """One change.

    changed: what changed. The heading of a mover that a rule sets is a `field`, the one that follows
    from its way a `heading`.
    owner: an agent's number, a mover, a cell, or None for the world.
    name: of the field or event, with its indices: `bag[raw]`.
    old, new: values as the interpreter has them; a reward, an event and a mark have only `new`.
    by: the statements that caused it; none for what timers do at a `tick`.
    lost: the statements that drew lots with those and lost.
    """

    changed: Changed
    owner: Owner = None
    name: str = ""
    old: Value = None
    new: Value = None
    type: ir.Type | None = None
    by: tuple[Done, ...] = ()
    draws: tuple[Used, ...] = ()
    lost: tuple[Done, ...] = ()


def effects_of(account: Account, board: Board, numbers: RandomNumbers) -> list[Effect]:
    """Returns the effects of a turn, in the order of its statements.

    Args:
      numbers: the random numbers drawn in it.
    """
    effects = [
        *_fields(account, board),
        *_bodies(account, board, numbers),
        *_announcements(account, board),
    ]
    numbers_of_statements = {id(done): number for number, done in enumerate(account.done)}

    def order(effect: Effect) -> int:
        return numbers_of_statements.get(id(effect.by[0]), -1) if effect.by else -1

    return sorted(effects, key=order)


# ---- fields


def _fields(account: Account, board: Board) -> Iterator[Effect]:
    """Yields the entries of fields that changed; fields of movers come last."""
    writers, losers = _writers(account)
    fields = sorted(board.fields.items(), key=lambda item: item[1].held_by.what == "mover")
    for (holder, _), field in fields:
        old = held_values(field, account.before)
        new = held_values(field, account.after)
        values: list[tuple[Owner, tuple[str, int] | None, Value, Value]] = [(None, None, old, new)]
        if field.held_by.what != "world":
            owners = _owners(field, holder, len(old), board)
            values = [
                (owner, (holder, number), old[number], new[number])
                for number, owner in enumerate(owners)
            ]
        for owner, slot_owner, old_value, new_value in values:
            for entries, label, was, now in _entries(field.type.indexed_by, old_value, new_value):
                slot = Slot(field.name, slot_owner, entries)
                by = tuple(writers[slot])
                if isinstance(owner, Mover) and field.name == "heading" and not by:
                    continue  # an effect of its movement
                lost = tuple(losers[slot])
                name = field.name + label
                yield Effect("field", owner, name, was, now, type=field.type, by=by, lost=lost)


def _owners(
    field: ir.VarField, holder: str, number: int, board: Board
) -> Sequence[int | Mover | Cell]:
    """Returns the agents, movers or cells that have a field, in the order of its values."""
    match field.held_by.what:
        case "cell":
            return board.cells[holder]
        case "mover":
            return [Mover(holder, n) for n in range(number)]
        case _:
            return range(number)


def _entries(
    by: tuple[ir.IndexSet, ...], old: Value, new: Value
) -> Iterator[tuple[tuple[int, ...], str, Value, Value]]:
    """Yields the entries of a field that differ: indices, their text (`[raw]`), both values."""
    if old == new:
        return
    if not by:
        yield (), "", old, new
        return
    for number, key in enumerate(by[0].keys):
        for entries, label, was, now in _entries(by[1:], old[number], new[number]):
            yield (number, *entries), f"[{key}]{label}", was, now


def _writers(account: Account) -> tuple[dict[Slot, list[Done]], dict[Slot, list[Done]]]:
    """Returns the statements that wrote each entry of a field, and those that lost its lot.

    A statement that was performed twice in one instance counts once.
    """
    writers: dict[Slot, list[Done]] = defaultdict(list)
    losers: dict[Slot, list[Done]] = defaultdict(list)
    winning = winners(lot for done in account.done for lot in done.written.get("lots", ()))
    for done in account.done:
        writes = (*done.written.get("sets", ()), *done.written.get("adds", ()))
        for slot in dict.fromkeys(slot for slot, _ in writes):
            writers[slot].append(done)
        for lot in done.written.get("lots", ()):
            performers = writers if winning[lot.slot] is lot else losers
            performers[lot.slot].append(done)
    return writers, losers


# ---- agents and movers


def _bodies(account: Account, board: Board, numbers: RandomNumbers) -> Iterator[Effect]:
    """Yields the changes of the place, heading, absence and movement of agents and movers."""
    written: set[Slot] = set()
    for done in account.done:
        written |= {slot for slot, _ in done.written.get("sets", ())}
        written |= {lot.slot for lot in done.written.get("lots", ())}
    for body in bodies(account.before):
        by = tuple(_senders(account, board, body))
        before = herd_of(body, account.before)
        after = herd_of(body, account.after)
        n = number_of(body)
        heading = heading_of(body, account.before)
        new_heading = heading_of(body, account.after)
        changes: list[tuple[Changed, Value, Value]] = [
            ("place", before.position[n], after.position[n]),
            ("heading", heading, new_heading),
            ("away", before.away[n], after.away[n]),
            ("moved", before.moved[n], after.moved[n]),
        ]
        for changed, old, new in changes:
            if changed == "heading" and isinstance(body, Mover):
                if Slot("heading", (body.entity_type, n), ()) in written:
                    continue  # an effect on a field
            if old != new:
                causes = by
                if changed != "heading":
                    causes = tuple(done for done in by if not isinstance(done.statement, ir.Face))
                used = tuple(_used(changed, body, account, causes, numbers))
                yield Effect(changed, body, old=old, new=new, by=causes, draws=used)


def _senders(account: Account, board: Board, body: Body) -> Iterator[Done]:
    """Yields the statements that move, send or remove a body in a turn.

    If it returns at a `tick`, that is the statement that sent it away.
    """
    away = away_of(body, account.before)
    if isinstance(account.turn, ir.Tick) and away is not None and away.pool is not None:
        if away_of(body, account.after) is None:
            yield Done(board.pools[away.pool], {}, (), {})
    for done in account.done:
        match done.statement:
            case ir.Move() if done.statement.domain.var.entity_type == type_of_body(body):
                yield done
            case ir.Send() if body in [sending.agent for sending in done.written.get("sends", ())]:
                yield done
            case ir.Shift() if body in [sent.agent for sent in done.written.get("shifts", ())]:
                yield done
            case ir.Face() if body in [agent for agent, _ in done.written.get("turns", ())]:
                yield done
            case ir.Remove(who=who):
                removed = agents_in(evaluate(who, _instance(done, account, board)))
                if body in list(removed):
                    yield done
            case _:
                pass


def _used(
    changed: str, body: Body, account: Account, by: Sequence[Done], numbers: RandomNumbers
) -> Iterator[Used]:
    """Yields the random numbers that decided a change of a body's place or heading."""
    if where_is(body, account.after) is None:
        return
    for done in by:
        statement = done.statement
        purpose: Purpose
        match changed, statement:
            case "heading", ir.Shift() | ir.Send():
                purpose = "which heading"
                stream = statement.heading_stream
            case "place", ir.Send():
                purpose = "which cell"
                stream = statement.cell_stream
            case "place", ir.Move(course=ir.Wander(stream=stream)):
                purpose = "which way"
            case _:
                continue
        if stream is None:
            continue
        if isinstance(account.turn, ir.Tick):
            stream = return_stream(stream)
        number = number_of(body)
        if (stream, number) in numbers:
            yield Used(purpose, stream, number, numbers[stream, number])


# ---- rewards, events, marks, ends


def _announcements(account: Account, board: Board) -> Iterator[Effect]:
    """Yields rewards, counts of events, marks, and the end of the episode."""
    events = {event.name: event for event in board.game.events}
    for done in account.done:
        for agent, value in done.written.get("gives", ()):
            if value:
                yield Effect("reward", agent, new=value, by=(done,))
        for counted in done.written.get("tallies", ()):
            if counted.amount:
                name = counted.event
                if events[name].by:
                    name += f"[{counted.word}]"
                yield Effect("event", counted.agent, name, new=counted.amount, by=(done,))
        match done.statement:
            case ir.Mark():
                near = ir.Near(shape=done.statement.shape, anchor=done.statement.anchor)
                cells = sorted(cells_in(near, _instance(done, account, board)))
                yield Effect("mark", new=tuple(cells), by=(done,))
            case ir.End():
                yield Effect("end", new=True, by=(done,))
            case _:
                pass


def _instance(done: Done, account: Account, board: Board) -> Instance:
    """Returns the instance in which a statement was performed, as far as it reads the state."""
    return Instance(board, account.before, names=done.names)

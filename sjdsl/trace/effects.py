"""The effects of one turn of the schedule: each change, with the statements that made it."""

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
    sort_of_body,
    where_is,
)
from sjdsl.interpreter.evaluate import agents_in, cells_in, evaluate
from sjdsl.interpreter.instance import Instance
from sjdsl.interpreter.state import Cell, Mover, Value
from sjdsl.interpreter.stored import held_values
from sjdsl.interpreter.threefry import return_stream
from sjdsl.interpreter.writes import Slot, winners

Sort = Literal["field", "place", "heading", "away", "moved", "reward", "event", "mark", "end"]
Purpose = Literal["which cell", "which heading", "which way"]
RandomNumbers = Mapping[tuple[int, int], int]  # (stream, number) -> 32 random bits


class Used(NamedTuple):
    """A random number that decided where an agent or a mover went: which cell, which heading, which way."""

    purpose: Purpose
    stream: int
    number: int
    bits: int


@dataclass(frozen=True)
class Effect:
    """One change: `old` and `new` as the interpreter holds them; a reward, an event and a mark have only `new`.

    owner: an agent's number, a mover, a cell, or None for the world. name: of the field or event, with its words (`bag[raw]`).
    by: the statements that made it; none for what timers do at a `tick`. lost: those that would have, and lost the lot.
    The heading of a mover that a rule sets is a field; the one that it has from its way is a heading.
    """

    sort: Sort
    owner: int | Mover | Cell | None
    name: str
    old: Value
    new: Value
    type: ir.Type | None = None
    by: tuple[Done, ...] = ()
    draws: tuple[Used, ...] = ()
    lost: tuple[Done, ...] = ()


def effects_of(account: Account, board: Board, numbers: RandomNumbers) -> list[Effect]:
    """Returns everything a turn changed, in the order of its statements. `numbers`: the random numbers taken in it."""
    found = [*_fields(account, board), *_of_bodies(account, board, numbers), *_said(account, board)]
    order = {id(done): number for number, done in enumerate(account.done)}
    return sorted(found, key=lambda effect: order.get(id(effect.by[0]), -1) if effect.by else -1)


# ---- fields


def _fields(account: Account, board: Board) -> Iterator[Effect]:
    writers, lost = _writers(account)
    before, after = account.before, account.after
    rows: list[
        tuple[ir.VarField, tuple[str, int] | None, int | Mover | Cell | None, Value, Value]
    ] = []
    for (holder, _), declared in sorted(
        board.fields.items(), key=lambda field: field[1].held_by.what == "mover"
    ):
        old, new = (held_values(declared, world) for world in (before, after))
        what = declared.held_by.what
        if what == "world":
            rows.append((declared, None, None, old, new))
        else:
            places = (
                board.cells[holder]
                if what == "cell"
                else [Mover(holder, n) if what == "mover" else n for n in range(len(old))]
            )
            rows += [
                (declared, (holder, n), *entry)
                for n, entry in enumerate(zip(places, old, new, strict=True))
            ]
    for declared, owner, place, old, new in rows:
        for entries, label, was, now in _entries(declared.type.by, old, new):
            slot = Slot(declared.name, owner, entries)
            by = tuple(writers[slot])
            if isinstance(place, Mover) and declared.name == "heading" and not by:
                continue  # it turns the way it goes, or as it is sent: told with its place
            yield Effect(
                "field",
                place,
                declared.name + label,
                was,
                now,
                declared.type,
                by,
                lost=tuple(lost[slot]),
            )


def _entries(
    by: tuple[ir.Level, ...], old: Value, new: Value
) -> Iterator[tuple[tuple[int, ...], str, Value, Value]]:
    """Yields the entries of a field that differ: indices, `[word]` for each level, both values."""
    if old == new:
        return
    if not by:
        yield (), "", old, new
        return
    for number, key in enumerate(by[0].keys):
        for entries, label, was, now in _entries(by[1:], old[number], new[number]):
            yield (number, *entries), f"[{key}]{label}", was, now


def _writers(account: Account) -> tuple[dict[Slot, list[Done]], dict[Slot, list[Done]]]:
    """Returns who wrote each entry of a field, and who lost the lot; a statement that was performed twice in one instance counts once."""
    found: dict[Slot, list[Done]] = defaultdict(list)
    lost: dict[Slot, list[Done]] = defaultdict(list)
    won = winners(lot for done in account.done for lot in done.written.get("lots", ()))
    for done in account.done:
        for slot in dict.fromkeys(
            slot for slot, _ in (*done.written.get("sets", ()), *done.written.get("adds", ()))
        ):
            found[slot].append(done)
        for lot in done.written.get("lots", ()):
            (found if won[lot.slot] is lot else lost)[lot.slot].append(done)
    return found, lost


# ---- agents and movers


def _of_bodies(account: Account, board: Board, numbers: RandomNumbers) -> Iterator[Effect]:
    """Yields what changed of the places, absence, movement and headings of agents and movers."""
    written = {slot for done in account.done for slot, _ in done.written.get("sets", ())}
    written |= {lot.slot for done in account.done for lot in done.written.get("lots", ())}
    for body in bodies(account.before):
        by = tuple(_senders(account, board, body))
        before, after, n = (
            herd_of(body, account.before),
            herd_of(body, account.after),
            number_of(body),
        )
        changes: list[tuple[Sort, Value, Value]] = [
            ("place", before.position[n], after.position[n]),
            ("away", before.away[n], after.away[n]),
            ("moved", before.moved[n], after.moved[n]),
        ]
        if not isinstance(body, Mover) or Slot("heading", (body.sort, n), ()) not in written:
            changes.insert(
                1, ("heading", heading_of(body, account.before), heading_of(body, account.after))
            )
        for sort, old, new in changes:
            if old != new:
                used = tuple(_used(sort, body, account, by, numbers))
                yield Effect(sort, body, "", old, new, None, by, used)


def _senders(account: Account, board: Board, body: Body) -> Iterator[Done]:
    """Yields the statements that move, send or remove somebody in this turn, or that sent it away when it returns at a `tick`."""
    away, back = away_of(body, account.before), away_of(body, account.after)
    if (
        isinstance(account.turn, ir.Tick)
        and away is not None
        and back is None
        and away.pool is not None
    ):
        yield Done(board.pools[away.pool], {}, (), {})
    for done in account.done:
        match done.statement:
            case ir.Move() if done.statement.domain.var.sort == sort_of_body(body):
                yield done
            case ir.Send() if body in [sending.agent for sending in done.written.get("sends", ())]:
                yield done
            case ir.Shift() if body in [sent.agent for sent in done.written.get("shifts", ())]:
                yield done
            case ir.Remove() if body in list(
                agents_in(evaluate(done.statement.who, _instance(done, account, board)))
            ):
                yield done
            case _:
                pass


def _used(
    sort: str, body: Body, account: Account, by: Sequence[Done], numbers: RandomNumbers
) -> Iterator[Used]:
    for statement in (done.statement for done in by):
        purpose: Purpose
        match sort, statement:
            case "heading", ir.Shift() | ir.Send():
                purpose, stream = "which heading", statement.heading_stream
            case "place", ir.Send():
                purpose, stream = "which cell", statement.cell_stream
            case "place", ir.Move(course=ir.Wander(stream=stream)):
                purpose = "which way"
            case _:
                continue
        if where_is(body, account.after) is None or stream is None:
            continue
        at = (
            return_stream(stream) if isinstance(account.turn, ir.Tick) else stream,
            number_of(body),
        )
        if at in numbers:
            yield Used(purpose, *at, numbers[at])


# ---- rewards, events, marks, ends


def _said(account: Account, board: Board) -> Iterator[Effect]:
    events = {event.name: event for event in board.game.events}
    for done in account.done:
        for agent, value in done.written.get("gives", ()):
            if value:
                yield Effect("reward", agent, "", None, value, None, (done,))
        for counted in done.written.get("tallies", ()):
            if counted.amount:
                word = f"[{counted.word}]" if events[counted.event].by else ""
                yield Effect(
                    "event",
                    counted.agent,
                    counted.event + word,
                    None,
                    counted.amount,
                    None,
                    (done,),
                )
        match done.statement:
            case ir.Mark():
                near = ir.Near(shape=done.statement.shape, anchor=done.statement.anchor)
                cells = sorted(cells_in(near, _instance(done, account, board)))
                yield Effect("mark", None, "", None, tuple(cells), None, (done,))
            case ir.End():
                yield Effect("end", None, "", None, True, None, (done,))
            case _:
                pass


def _instance(done: Done, account: Account, board: Board) -> Instance:
    return Instance(board, account.before, names=done.names)

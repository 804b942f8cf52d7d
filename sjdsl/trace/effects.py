"""The effects of one turn of the schedule: each change, with the statements that made it."""

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

from sjdsl.compiler import ir
from sjdsl.compiler.ir.sorts import entry_name
from sjdsl.interpreter.account import Account, Done
from sjdsl.interpreter.board import Board
from sjdsl.interpreter.evaluate import agents_in, cells_in, evaluate
from sjdsl.interpreter.instance import Instance
from sjdsl.interpreter.state import Away, Cell, Value
from sjdsl.interpreter.threefry import return_stream
from sjdsl.interpreter.writes import Slot

Sort = Literal["field", "place", "heading", "away", "moved", "reward", "event", "mark", "end"]
RandomNumbers = Mapping[tuple[int, int], int]  # (stream, number) -> 32 random bits


class Used(NamedTuple):
    """A random number that decided where an agent went: which cell, which heading, who of several."""

    purpose: Literal["who comes first", "which cell", "which heading"]
    stream: int
    number: int
    bits: int


@dataclass(frozen=True)
class Effect:
    """One change: `old` and `new` as the interpreter holds them; a reward, an event and a mark have only `new`.

    owner: an agent's number, a cell, or None for the world. name: of the field or event, with its words (`bag[raw]`).
    by: the statements that made it; none for what timers do at a `tick`.
    """

    sort: Sort
    owner: int | Cell | None
    name: str
    old: Value
    new: Value
    type: ir.Type | None = None
    by: tuple[Done, ...] = ()
    draws: tuple[Used, ...] = ()


def effects_of(account: Account, board: Board, numbers: RandomNumbers) -> list[Effect]:
    """Returns everything a turn changed, in the order of its statements. `numbers`: the random numbers taken in it."""
    found = [*_fields(account, board), *_agents(account, board, numbers), *_said(account, board)]
    order = {id(done): number for number, done in enumerate(account.done)}
    return sorted(found, key=lambda effect: order.get(id(effect.by[0]), -1) if effect.by else -1)


def without_effect(account: Account, effects: Sequence[Effect]) -> list[Done]:
    """Returns the statements that happened and changed nothing."""
    busy = {id(done) for effect in effects for done in effect.by}
    return [done for done in account.done if id(done) not in busy]


# ---- fields


def _fields(account: Account, board: Board) -> Iterator[Effect]:
    writers = _writers(account)
    before, after = account.before, account.after
    rows: list[tuple[ir.VarField, tuple[str, int] | None, int | Cell | None, Value, Value]] = []
    for (kind, name), declared in board.cell_fields.items():
        pairs = zip(before.cells[kind, name], after.cells[kind, name], strict=True)
        rows += [(declared, (kind, n), board.cells[kind][n], old, new) for n, (old, new) in enumerate(pairs)]
    for name, declared in board.agent_fields.items():
        pairs = zip(before.agents[name], after.agents[name], strict=True)
        rows += [(declared, ("agent", n), n, old, new) for n, (old, new) in enumerate(pairs)]
    rows += [(declared, None, None, before.fields[name], after.fields[name]) for name, declared in board.world_fields.items()]
    for declared, owner, place, old, new in rows:
        for entries, label, was, now in _entries(declared.type.by, old, new):
            by = tuple(writers[Slot(declared.name, owner, entries)])
            yield Effect("field", place, declared.name + label, was, now, declared.type, by)


def _entries(by: tuple[tuple[str, ...], ...], old: Value, new: Value) -> Iterator[tuple[tuple[int, ...], str, Value, Value]]:
    """Yields the entries of a field that differ: indices, `[word]` for each level, both values."""
    if old == new:
        return
    if not by:
        yield (), "", old, new
        return
    for number, name in enumerate(by[0]):
        for entries, label, was, now in _entries(by[1:], old[number], new[number]):
            yield (number, *entries), f"[{entry_name(name)}]{label}", was, now


def _writers(account: Account) -> dict[Slot, list[Done]]:
    """Returns who wrote each entry of a field; a statement that was performed twice in one instance counts once."""
    found: dict[Slot, list[Done]] = defaultdict(list)
    for done in account.done:
        for slot in dict.fromkeys(slot for slot, _ in (*done.written.get("sets", ()), *done.written.get("adds", ()))):
            found[slot].append(done)
    return found


# ---- agents


def _agents(account: Account, board: Board, numbers: RandomNumbers) -> Iterator[Effect]:
    before, after = account.before, account.after
    for agent in range(board.agents):
        by = tuple(_senders(account, board, agent))
        changes: tuple[tuple[Sort, Value, Value], ...] = (
            ("place", before.position[agent], after.position[agent]),
            ("heading", before.heading[agent], after.heading[agent]),
            ("away", before.away[agent], after.away[agent]),
            ("moved", before.moved[agent], after.moved[agent]),
        )
        for sort, old, new in changes:
            if old != new:
                used = tuple(_used(sort, agent, account, board, by, numbers))
                yield Effect(sort, agent, "", old, new, None, by, used)


def _senders(account: Account, board: Board, agent: int) -> Iterator[Done]:
    """Yields the statements that move, send or remove an agent in this turn, or that sent it away when it returns at a `tick`."""
    away = account.before.away[agent]
    if isinstance(account.turn, ir.Tick) and away is not None and account.after.away[agent] is None and away.pool is not None:
        yield Done(board.pools[away.pool], {}, (), {})
    for done in account.done:
        match done.statement:
            case ir.Move():
                yield done
            case ir.Send() if agent in {sending.agent for sending in done.written.get("sends", ())}:
                yield done
            case ir.Shift() if agent in {sent.agent for sent in done.written.get("shifts", ())}:
                yield done
            case ir.Remove() if agent in agents_in(evaluate(done.statement.who, _instance(done, account, board))):
                yield done
            case _:
                pass


def _used(sort: str, agent: int, account: Account, board: Board, by: Sequence[Done], numbers: RandomNumbers) -> Iterator[Used]:
    place = account.after.position[agent]
    for statement in (done.statement for done in by):
        if isinstance(statement, ir.Shift) and sort == "place" and (at := (statement.stream, agent)) in numbers:
            yield Used("who comes first", *at, numbers[at])
        if isinstance(statement, ir.Shift) and sort == "heading" and (at := (statement.heading_stream or 0, agent)) in numbers:
            yield Used("which heading", *at, numbers[at])
        if isinstance(statement, ir.Move) and sort == "place":
            own = ((stream, n) for stream, n in numbers if stream == statement.stream and n % board.agents == agent)
            yield from (Used("who comes first", *at, numbers[at]) for at in own)
        if not isinstance(statement, ir.Send) or place is None:
            continue
        order, heading = statement.order_stream, statement.heading_stream
        if isinstance(account.turn, ir.Tick):
            order, heading = return_stream(order), return_stream(heading)
        at = (order if sort == "place" else heading, agent)
        if sort in ("place", "heading") and at in numbers:
            yield Used("which cell" if sort == "place" else "which heading", *at, numbers[at])


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
                yield Effect("event", counted.agent, counted.event + word, None, counted.amount, None, (done,))
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


def plain(value: Value) -> Any:
    """Returns a value as JSON has it: nobody null, a set of agents a list, a cell `[row, col]`, who is away its ticks (0: for ever)."""
    match value:
        case frozenset():
            return sorted(value)
        case Away():
            return value.ticks
        case Cell():
            return [value.row, value.col]
        case tuple():
            return [plain(entry) for entry in value]
        case None | bool() | str() | int():
            return value
        case _:
            return value.item() if hasattr(value, "item") else value

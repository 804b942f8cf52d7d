"""The writes of a phase: collected while it runs, applied together at its end, with write conflicts asserted to be absent."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import reduce
from operator import getitem
from typing import Any, NamedTuple

import numpy as np

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import written_field, written_keys
from sjdsl.compiler.ir.sorts import AGENTS
from sjdsl.interpreter.account import Done, Drawn
from sjdsl.interpreter.board import Board
from sjdsl.interpreter.bodies import Body
from sjdsl.interpreter.evaluate import agents_in, entry_place, evaluate
from sjdsl.interpreter.instance import Instance
from sjdsl.interpreter.numbers import added_up, check_int32, check_interval
from sjdsl.interpreter.state import Cell, Mover, Value, World
from sjdsl.interpreter.stored import held_values


class Slot(NamedTuple):
    """One entry of one field. `owner`: (kind or sort, number of the cell or mover), ("agent", id) or None; `entries`: one index a `by` level."""

    name: str
    owner: tuple[str, int] | None
    entries: tuple[int, ...]


class Sending(NamedTuple):
    """An agent or a mover on its way by this statement, `ticks` from now (0: at once).

    names: the variables around, which its destination may name.
    """

    agent: Body
    send: ir.Send
    ticks: int
    names: Mapping[str, Value]


class Shifting(NamedTuple):
    """An agent sent some cells by this statement. `target`: its own cell if the way is not free; None of who has no cell."""

    agent: Body
    statement: ir.Shift
    target: Cell | None


class Counted(NamedTuple):
    """One tally. `word`: the key (a word, a number, an agent) of an event with entries; `agent` None for the game."""

    event: str
    word: str | int | None
    agent: int | None
    amount: int


class Lot(NamedTuple):
    """Who would write an entry of a field `by lot`: the greatest rank does; of equal ones the statement written first, then by number.

    place: where the statement is written, and the number of the instance.
    """

    slot: Slot
    value: Value
    rank: int
    place: tuple[int, int]


def winners(lots: Iterable[Lot]) -> dict[Slot, Lot]:
    """Returns for each entry of a field who of those that would write it does."""
    return {
        lot.slot: lot
        for lot in sorted(lots, key=lambda lot: (lot.rank, *(-part for part in lot.place)))
    }


_LISTS = ("sets", "adds", "lots", "gives", "tallies", "sends", "shifts")
_WRITING = (
    ir.Set,
    ir.Add,
    ir.Give,
    ir.Tally,
    ir.Send,
    ir.Shift,
    ir.Remove,
    ir.Move,
    ir.Mark,
    ir.End,
)


@dataclass
class Writes:
    """Everything the statements of one phase wrote. `movers`: rank of each agent or mover of a `move`, None without one.

    sort: of those who `move`. courses: the direction in which each mover of a `move` goes, None if it stays. lots: those who would write
    a target `by lot`.

    done, drawn: an account of it, statement by statement, where one is wanted; else None.
    """

    sets: list[tuple[Slot, Value]] = field(default_factory=list)
    adds: list[tuple[Slot, Value]] = field(default_factory=list)
    lots: list[Lot] = field(default_factory=list)
    gives: list[tuple[int, np.float32]] = field(default_factory=list)
    tallies: list[Counted] = field(default_factory=list)
    sends: list[Sending] = field(default_factory=list)
    shifts: list[Shifting] = field(default_factory=list)
    removes: set[Body] = field(default_factory=set)
    movers: dict[Body, int] | None = None
    sort: ir.Sort = AGENTS
    courses: dict[Body, int | None] = field(default_factory=dict)
    marks: set[Cell] = field(default_factory=set)
    end: bool = False
    done: list[Done] | None = None
    drawn: list[Drawn] | None = None

    def sizes(self) -> dict[str, int]:
        """Returns how much was written so far, of what comes in lists; nothing where no account is wanted."""
        return {} if self.done is None else {name: len(getattr(self, name)) for name in _LISTS}

    def tell(self, statement: ir.Stmt, here: Instance, before: dict[str, int]) -> None:
        """Keeps what a statement that writes (not one that has others in it) has written since `before`."""
        if self.done is not None and isinstance(statement, _WRITING):
            written = {
                name: tuple(getattr(self, name)[size:])
                for name, size in before.items()
                if len(getattr(self, name)) > size
            }
            self.done.append(Done(statement, here.names, here.causes, written))


def slots(target: ir.Expr, value: Value, here: Instance) -> list[tuple[Slot, Value]]:
    """Returns the entries a target names, each with its value: a row gets a row entry by entry, or one value everywhere."""
    written = written_field(target)
    keys = written_keys(target)
    levels = written.type.by
    entries = [
        entry_place(level, evaluate(key, here)) for level, key in zip(levels, keys, strict=False)
    ]
    slot = Slot(written.name, _owner(written, here), tuple(entries))
    return _spread(slot, value, levels[len(keys) :])


def declaration(slot: Slot, board: Board) -> ir.VarField:
    """Returns the field a slot belongs to."""
    return board.fields["world" if slot.owner is None else slot.owner[0], slot.name]


def _owner(target: ir.FieldRead, here: Instance) -> tuple[str, int] | None:
    if target.owner is None:
        return None
    owner = evaluate(target.owner, here)
    assert owner is not None, f"`{target.name}` of nobody is written"
    if target.held_by.what == "agent":
        return "agent", owner
    if isinstance(owner, Mover):
        return owner.sort, owner.number
    return here.board.kind_of[owner], here.board.number[owner]


def _spread(slot: Slot, value: Value, levels: tuple[ir.Level, ...]) -> list[tuple[Slot, Value]]:
    if not levels:
        return [(slot, value)]
    values = (
        value
        if isinstance(value, tuple) and not isinstance(value, Cell)
        else (value,) * len(levels[0])
    )
    assert len(values) == len(levels[0]), slot
    inner = [
        _spread(slot._replace(entries=(*slot.entries, i)), v, levels[1:])
        for i, v in enumerate(values)
    ]
    return [pair for pairs in inner for pair in pairs]


def write_fields(writes: Writes, board: Board, world: World) -> None:
    """Changes the fields of `world`, which holds the snapshot's values: what is set, then all that is added, summed."""
    sets: dict[Slot, Value] = {}
    drawn = [(slot, lot.value) for slot, lot in winners(writes.lots).items()]
    for slot, value in (*writes.sets, *drawn):
        value = _as_held(declaration(slot, board), value)
        assert sets.setdefault(slot, value) == value, (
            f"{slot} is set to {sets[slot]} and to {value}"
        )
    adds: dict[Slot, list[Value]] = {}
    for slot, value in writes.adds:
        adds.setdefault(slot, []).append(_as_held(declaration(slot, board), value))
    for slot, value in sets.items():
        _put(slot, value, board, world)
    for slot, values in adds.items():
        declared = declaration(slot, board)
        assert slot not in sets or declared.type.kind == "agents", f"{slot} is set and added to"
        _put(slot, _added(declared, _get(slot, board, world), values), board, world)
    for slot in (*sets, *adds):
        _check(declaration(slot, board), _get(slot, board, world), board)


def _as_held(declared: ir.VarField, value: Value) -> Value:
    """Returns a value as a field of this type holds it."""
    kind = declared.type.kind
    return (
        frozenset(agents_in(value))
        if kind == "agents"
        else np.float32(value)
        if kind == "real"
        else value
    )


def _added(declared: ir.VarField, before: Value, values: list[Value]) -> Value:
    if declared.type.kind == "agents":
        return before.union(*values)
    if declared.type.kind == "real":
        return added_up([before, *values])
    after = before + sum(values)
    check_int32(after, declared.name)
    return int(min(max(after, declared.type.low), declared.type.high)) if declared.capped else after


def _check(declared: ir.VarField, value: Value, board: Board) -> None:
    match declared.type.kind:
        case "int" | "real":
            check_interval(value, declared.type, declared.name)
        case "word":
            assert value in declared.type.words, (declared.name, value)
        case "agent" | "agents":
            assert all(agent in range(board.agents) for agent in agents_in(value)), (
                declared.name,
                value,
            )
        case "cell":
            assert value is None or board.kind_of[value] in declared.type.kinds, (
                declared.name,
                value,
            )
        case _:
            raise AssertionError(declared)


def _get(slot: Slot, board: Board, world: World) -> Value:
    values, place = _holder(slot, board, world)
    return reduce(getitem, slot.entries, values[place])


def _put(slot: Slot, value: Value, board: Board, world: World) -> None:
    values, place = _holder(slot, board, world)
    values[place] = _replaced(values[place], slot.entries, value)


def _holder(slot: Slot, board: Board, world: World) -> tuple[Any, Any]:
    """Returns the list or dictionary that the field's value is kept in, and its place there."""
    return (
        (world.fields, slot.name)
        if slot.owner is None
        else (held_values(declaration(slot, board), world), slot.owner[1])
    )


def _replaced(whole: Value, entries: tuple[int, ...], value: Value) -> Value:
    if not entries:
        return value
    first = entries[0]
    return (*whole[:first], _replaced(whole[first], entries[1:], value), *whole[first + 1 :])

"""The writes of a phase, collected while it runs and applied together at its end.

Applying them asserts that there is no write conflict.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import reduce
from operator import getitem
from typing import Any, NamedTuple

import numpy as np

from sjdsl.compiler import ir
from sjdsl.compiler.ir.entity_types import AGENTS
from sjdsl.compiler.ir.queries import written_field, written_keys
from sjdsl.interpreter.account import Done, Drawn
from sjdsl.interpreter.board import Board
from sjdsl.interpreter.bodies import Body
from sjdsl.interpreter.evaluate import agents_in, entry_place, evaluate
from sjdsl.interpreter.instance import Instance
from sjdsl.interpreter.numbers import added_up, check_int32, check_interval
from sjdsl.interpreter.state import Cell, Facing, Mover, Value, World
from sjdsl.interpreter.stored import held_values


class Slot(NamedTuple):
    """One entry of one field."""

    name: str
    # (kind or entity type, number of the cell or mover), ("agent", number), or None for the world.
    owner: tuple[str, int] | None
    entries: tuple[int, ...]  # the indices of an entry of a `by` field


class Sending(NamedTuple):
    """An agent or a mover that a `send` sends."""

    agent: Body
    send: ir.Send
    ticks: int  # until it arrives; 0: at once
    facing: Facing | None  # then; None: any way
    names: Mapping[str, Value]  # the variables around, which the destination may read


class Shifting(NamedTuple):
    """An agent or a mover that a `send … by` or `send … to CELL` sends."""

    agent: Body
    statement: ir.Shift
    target: Cell | None  # its own cell if the way is blocked; None if it is off the map
    facing: Facing | None  # there; None: any way


class Counted(NamedTuple):
    """One tally."""

    event: str
    word: str | int | None  # the key of an event with keys: an enum value, a number or an agent
    agent: int | None  # None: counted for the whole game
    amount: int


class Lot(NamedTuple):
    """A write `by lot`.

    Of several to one entry, that with the largest rank is applied; of equal ranks that of the first
    statement in the file, then of the smallest instance number.
    """

    slot: Slot
    value: Value
    rank: int
    place: tuple[int, int]  # the position of the statement, and the number of the instance


def winners(lots: Iterable[Lot]) -> dict[Slot, Lot]:
    """Returns the write `by lot` that is applied to each entry."""

    def order(lot: Lot) -> tuple[int, int, int]:
        position, number = lot.place
        return lot.rank, -position, -number

    return {lot.slot: lot for lot in sorted(lots, key=order)}


_LISTS = ("sets", "adds", "lots", "gives", "tallies", "sends", "shifts", "turns")
_WRITING = (
    ir.Set,
    ir.Add,
    ir.Give,
    ir.Tally,
    ir.Send,
    ir.Shift,
    ir.Face,
    ir.Remove,
    ir.Move,
    ir.Mark,
    ir.End,
)


@dataclass
class Writes:
    """The writes of the statements of one phase."""

    sets: list[tuple[Slot, Value]] = field(default_factory=list)
    adds: list[tuple[Slot, Value]] = field(default_factory=list)
    lots: list[Lot] = field(default_factory=list)
    gives: list[tuple[int, np.float32]] = field(default_factory=list)
    tallies: list[Counted] = field(default_factory=list)
    sends: list[Sending] = field(default_factory=list)
    shifts: list[Shifting] = field(default_factory=list)
    turns: list[tuple[int, str]] = field(default_factory=list)  # agents and their new headings
    removes: set[Body] = field(default_factory=set)
    movers: dict[Body, int] | None = None  # the rank of each agent or mover of a `move`
    entity_type: ir.EntityType = AGENTS  # the entity type of those who `move`
    courses: dict[Body, int | None] = field(default_factory=dict)  # of movers; None: it stays
    marks: set[Cell] = field(default_factory=set)
    end: bool = False
    # The account of the phase, or None if none is wanted.
    done: list[Done] | None = None
    drawn: list[Drawn] | None = None

    def sizes(self) -> dict[str, int]:
        """Returns the current lengths of the lists; empty if no account is wanted."""
        return {} if self.done is None else {name: len(getattr(self, name)) for name in _LISTS}

    def record(self, statement: ir.Stmt, instance: Instance, sizes: dict[str, int]) -> None:
        """Adds a statement to the account, with the entries of lists beyond their former sizes.

        Statements that contain others aren't recorded.
        """
        if self.done is None or not isinstance(statement, _WRITING):
            return
        written = {name: tuple(getattr(self, name)[size:]) for name, size in sizes.items()}
        written = {name: entries for name, entries in written.items() if entries}
        self.done.append(Done(statement, instance.names, instance.causes, written))


def slots(target: ir.Expr, value: Value, instance: Instance) -> list[tuple[Slot, Value]]:
    """Returns the entries of a target, each with its value.

    A target with several entries gets a tuple entry by entry, or one value for all.
    """
    written = written_field(target)
    keys = written_keys(target)
    index_sets = written.type.indexed_by
    entries = tuple(
        entry_place(index_set, evaluate(key, instance))
        for index_set, key in zip(index_sets[: len(keys)], keys, strict=True)
    )
    slot = Slot(written.name, _owner(written, instance), entries)
    return _spread(slot, value, index_sets[len(keys) :])


def declaration(slot: Slot, board: Board) -> ir.VarField:
    """Returns the field a slot belongs to."""
    return board.fields["world" if slot.owner is None else slot.owner[0], slot.name]


def _owner(target: ir.FieldRead, instance: Instance) -> tuple[str, int] | None:
    """Returns the owner of a field that is written, as in `Slot`."""
    if target.owner is None:
        return None
    owner = evaluate(target.owner, instance)
    assert owner is not None, f"`{target.name}` of nobody is written"
    if target.held_by.what == "agent":
        return "agent", owner
    if isinstance(owner, Mover):
        return owner.entity_type, owner.number
    return instance.board.kind_of[owner], instance.board.number[owner]


def _spread(
    slot: Slot, value: Value, index_sets: tuple[ir.IndexSet, ...]
) -> list[tuple[Slot, Value]]:
    """Returns the entries of a slot over its further index sets, each with its value."""
    if not index_sets:
        return [(slot, value)]
    first, *inner = index_sets
    if not isinstance(value, tuple) or isinstance(value, Cell):
        value = (value,) * len(first)
    assert len(value) == len(first), slot
    pairs: list[tuple[Slot, Value]] = []
    for index, entry in enumerate(value):
        pairs += _spread(slot._replace(entries=(*slot.entries, index)), entry, tuple(inner))
    return pairs


def write_fields(writes: Writes, board: Board, world: World) -> None:
    """Changes the fields of `world`, which holds the values of the snapshot.

    Sets them, then adds.
    """
    by_lot = [(slot, lot.value) for slot, lot in winners(writes.lots).items()]
    sets: dict[Slot, Value] = {}
    for slot, value in (*writes.sets, *by_lot):
        value = _converted(declaration(slot, board), value)
        assert sets.setdefault(slot, value) == value, (
            f"{slot} is set to {sets[slot]} and to {value}"
        )
    adds: dict[Slot, list[Value]] = {}
    for slot, value in writes.adds:
        adds.setdefault(slot, []).append(_converted(declaration(slot, board), value))
    for slot, value in sets.items():
        _put(slot, value, board, world)
    for slot, values in adds.items():
        declared = declaration(slot, board)
        assert slot not in sets or declared.type.kind == "agents", f"{slot} is set and added to"
        _put(slot, _added(declared, _get(slot, board, world), values), board, world)
    for slot in (*sets, *adds):
        _check(declaration(slot, board), _get(slot, board, world), board)


def _converted(declared: ir.VarField, value: Value) -> Value:
    """Returns a value of the type of a field."""
    match declared.type.kind:
        case "agents":
            return frozenset(agents_in(value))
        case "real":
            return np.float32(value)
        case _:
            return value


def _added(declared: ir.VarField, current: Value, values: list[Value]) -> Value:
    """Returns the current value of a field with others added to it."""
    if declared.type.kind == "agents":
        return current.union(*values)
    if declared.type.kind == "real":
        added = added_up([current, *values])
        if declared.capped:
            return min(max(added, np.float32(declared.type.low)), np.float32(declared.type.high))
        return added
    total = current + sum(values)
    check_int32(total, declared.name)
    if declared.capped:
        return int(min(max(total, declared.type.low), declared.type.high))
    return total


def _check(declared: ir.VarField, value: Value, board: Board) -> None:
    """Asserts that a value is one of its field's type."""
    match declared.type.kind:
        case "int" | "real":
            check_interval(value, declared.type, declared.name)
            _check_ends(value, declared)
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


def _check_ends(value: Value, declared: ir.VarField) -> None:
    """Asserts that a number, or each of a row, is in its field's range to the last bit."""
    if isinstance(value, tuple):
        for entry in value:
            _check_ends(entry, declared)
        return
    assert declared.type.low <= value <= declared.type.high, (declared.name, value)


def _get(slot: Slot, board: Board, world: World) -> Value:
    """Returns the value of a slot."""
    values, key = _holder(slot, board, world)
    return reduce(getitem, slot.entries, values[key])


def _put(slot: Slot, value: Value, board: Board, world: World) -> None:
    """Sets the value of a slot."""
    values, key = _holder(slot, board, world)
    values[key] = with_entry(values[key], slot.entries, value)


def _holder(slot: Slot, board: Board, world: World) -> tuple[Any, Any]:
    """Returns the list or dictionary with a field's values, and the index or key of the slot's."""
    if slot.owner is None:
        return world.fields, slot.name
    _, number = slot.owner
    return held_values(declaration(slot, board), world), number


def with_entry(value: Value, entries: tuple[int, ...], entry: Value) -> Value:
    """Returns nested tuples with one entry replaced."""
    if not entries:
        return entry
    first, *rest = entries
    return (*value[:first], with_entry(value[first], tuple(rest), entry), *value[first + 1 :])

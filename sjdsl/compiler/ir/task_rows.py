"""The parts of a task, and the table of a side: the values that its conditions' parts can have.

    hold out light of rules where pay[red] > 7   ->   parts (pay[red],), rows ((8,), (9,))

A part is a field, or one entry of a row. A condition reads some of them, and the others are free.
"""

import math
from collections.abc import Iterator, Sequence
from itertools import permutations, product
from typing import Any

from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.diagnostics.tree import children
from sjdsl.compiler.ir.expressions import At, Expr, FieldRead, Number, Word
from sjdsl.compiler.ir.fold import UnknownValue, fold
from sjdsl.compiler.ir.game import HoldOut, Task, TaskPart
from sjdsl.compiler.ir.node import Node
from sjdsl.compiler.ir.statements import Draw
from sjdsl.compiler.ir.values import Evaluation

Part = int | str  # the value of one: a number or a word
Row = tuple[Part, ...]


class SideRows(Record):
    """What a side has: each of its tasks has one of the rows in these parts, all equally likely."""

    parts: tuple[TaskPart, ...]
    rows: tuple[Row, ...]


def drawn_fields(task: Task) -> tuple[Draw, ...]:
    """Returns what is drawn for each field, in the order of declaration."""
    return tuple(statement for statement in task.draw.body if isinstance(statement, Draw))


def drawn_field(task: Task, name: str) -> Draw:
    """Returns what is drawn for the field of a name."""
    return next(drawn for drawn in drawn_fields(task) if drawn.name == name)


def values_of(drawn: Draw) -> tuple[Part, ...]:
    """Returns the values that a field, or an entry of a row, can have."""
    if drawn.words:
        return drawn.words
    return tuple(range(int(drawn.type.low), int(drawn.type.high) + 1))


def parts_of(drawn: Draw) -> tuple[TaskPart, ...]:
    """Returns the parts of one field: itself, or the entries of the row."""
    if drawn.by is None:
        return (TaskPart(field=drawn.name),)
    return tuple(TaskPart(field=drawn.name, place=place) for place in range(len(drawn.by)))


def all_parts(task: Task) -> tuple[TaskPart, ...]:
    """Returns the parts of all fields, in the order of declaration."""
    return tuple(part for drawn in drawn_fields(task) for part in parts_of(drawn))


def part_name(part: TaskPart, task: Task) -> str:
    """Returns a part as it is written: `hue`, `pay[red]`."""
    drawn = drawn_field(task, part.field)
    if part.place is None:
        return part.field
    assert drawn.by is not None
    return f"{part.field}[{drawn.by.keys[part.place]}]"


def number_of_ways(task: Task, parts: Sequence[TaskPart]) -> int:
    """Returns how many rows some parts can have, all equally likely."""
    ways = 1
    for drawn in drawn_fields(task):
        values = len(values_of(drawn))
        number = sum(part.field == drawn.name for part in parts)
        ways *= math.perm(values, number) if drawn.different else values**number
    return ways


def parts_read(task: Task, conditions: Sequence[Expr]) -> tuple[TaskPart, ...]:
    """Returns the parts that conditions read, in the order of declaration.

    Of a row with a key that isn't written out, all entries are read.
    """
    read = {part for condition in conditions for part in _read(condition)}
    whole_rows = {part.field for part in read if part.place is None}
    return tuple(part for part in all_parts(task) if part in read or part.field in whole_rows)


def _read(e: Node) -> Iterator[TaskPart]:
    """Yields the parts that an expression reads; of a whole row, one without a place."""
    match e:
        case At(row=FieldRead() as row, key=Word() | Number() as key):
            written = key.value if isinstance(key, Word) else int(key.value)
            yield TaskPart(field=row.name, place=row.type.indexed_by[0].place_of(written))
        case FieldRead():
            yield TaskPart(field=e.name)
        case _:
            for child in children(e):
                yield from _read(child)


def rows_of_training(task: Task) -> SideRows:
    """Returns the tasks for which the condition of no `hold out` holds."""
    parts, rows = _side(task, task.hold_outs, some_holds=False)
    return SideRows(parts, tuple(rows))


def rows_of_hold_out(task: Task, hold_out: HoldOut) -> SideRows:
    """Returns the tasks for which the condition of a `hold out` holds."""
    parts, rows = _side(task, (hold_out,), some_holds=True)
    return SideRows(parts, tuple(rows))


def holds_out_any(task: Task, hold_out: HoldOut) -> bool:
    """Returns whether the condition of a `hold out` holds for a task; lists no more than one."""
    _, rows = _side(task, (hold_out,), some_holds=True)
    return next(rows, None) is not None


def _side(
    task: Task, hold_outs: Sequence[HoldOut], some_holds: bool
) -> tuple[tuple[TaskPart, ...], Iterator[Row]]:
    """Returns the parts that conditions read, and their rows for which some holds, or none."""
    conditions = tuple(hold_out.condition for hold_out in hold_outs)
    parts = parts_read(task, conditions)
    return parts, _rows(task, parts, conditions, some_holds)


def rows_of_side(task: Task) -> SideRows:
    """Returns the rows of the side that is played, or the one row of the parts that are given."""
    if task.given:
        return SideRows(
            tuple(given.part for given in task.given), (tuple(g.value for g in task.given),)
        )
    match task.side:
        case "all":
            return SideRows((), ((),))
        case "held_out" if task.split != task.name:
            return rows_of_hold_out(task, next(h for h in task.hold_outs if h.name == task.split))
        case _:
            return rows_of_training(task)


def tasks_with(rows: SideRows, task: Task) -> int:
    """Returns how many tasks there are with one of the rows."""
    free = number_of_ways(task, all_parts(task)) // number_of_ways(task, rows.parts)
    return free * len(rows.rows)


def _rows(
    task: Task, parts: Sequence[TaskPart], conditions: Sequence[Expr], some_holds: bool
) -> Iterator[Row]:
    """Yields the rows of the parts that conditions read for which some holds, or none does."""
    columns = {part: column for column, part in enumerate(parts)}
    columns_of_fields = {
        drawn.name: tuple(columns.get(part) for part in parts_of(drawn))
        for drawn in drawn_fields(task)
        if any(part.field == drawn.name for part in parts)
    }
    rows_by_key = {drawn.name for drawn in drawn_fields(task) if drawn.by is not None}
    fields: dict[str, Any] = {}  # of the row that is looked at; entries that nothing reads are None

    def read(e: Expr) -> Any:
        if not isinstance(e, FieldRead):
            raise UnknownValue
        return fields[e.name]

    evaluation = Evaluation(read)
    for row in _all_rows(task, parts):
        for name, of_field in columns_of_fields.items():
            values = tuple(None if column is None else row[column] for column in of_field)
            fields[name] = values if name in rows_by_key else values[0]
        if any(fold(condition, evaluation) for condition in conditions) == some_holds:
            yield row


def _all_rows(task: Task, parts: Sequence[TaskPart]) -> Iterator[Row]:
    """Yields every row of some parts, in the order of their values, the last part first."""
    of_fields = []
    for drawn in drawn_fields(task):
        number = sum(part.field == drawn.name for part in parts)
        values = values_of(drawn)
        several = permutations(values, number)
        of_fields.append(several if drawn.different else product(values, repeat=number))
    for rows in product(*of_fields):
        yield tuple(value for row in rows for value in row)

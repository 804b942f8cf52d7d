"""The task of an episode: which key it is drawn from, and what a split says of its parts."""

from collections.abc import Callable, Iterator
from itertools import product
from typing import Any

from sjdsl.compiler import ir
from sjdsl.compiler.ir.task_rows import parts_read
from sjdsl.interpreter.board import Board
from sjdsl.interpreter.evaluate import evaluate
from sjdsl.interpreter.instance import Instance
from sjdsl.interpreter.state import Value, World, copied
from sjdsl.interpreter.threefry import Draws, Threefry

Row = tuple[Value, ...]


def key_of_task(task: ir.Task, draws: Draws, drawn: Callable[[Draws], World]) -> Draws:
    """Returns the key that the task of an episode is drawn from.

    drawn: returns a state with the task that is drawn from a key.
    """
    train_on = task.train_on
    if task.given or train_on is None or task.side == "all":
        return draws
    stream = task.number_stream
    if task.side == "training":
        number = draws.bits(stream, 0) * train_on.number >> 32
        return Threefry(train_on.seed, number)
    if task.split != task.name:
        return draws
    training = _training_tasks(task, train_on, drawn)
    candidates = []
    for number in range(train_on.candidates):
        words = draws.bits(stream, 2 * number), draws.bits(stream, 2 * number + 1)
        candidates.append(Threefry(*words))
    for candidate in candidates:
        if _values(task, drawn(candidate)) not in training:
            return candidate
    return candidates[0]


_training: dict[int, tuple[ir.Task, set[Row]]] = {}  # those of the tasks played, by identity


def _training_tasks(
    task: ir.Task, train_on: ir.TrainOn, drawn: Callable[[Draws], World]
) -> set[Row]:
    """Returns the values of all tasks to train on."""
    if id(task) not in _training:
        worlds = [drawn(Threefry(train_on.seed, number)) for number in range(train_on.number)]
        _training[id(task)] = task, {_values(task, world) for world in worlds}
    return _training[id(task)][1]


def _values(task: ir.Task, world: World) -> Row:
    return tuple(world.fields[name] for name in task.fields)


def fix_parts(world: World, board: Board, draws: Draws) -> None:
    """Gives the parts of a task that isn't any task, but one of a side, their values."""
    task = board.game.task
    assert task is not None
    if task.given:
        for given in task.given:
            _fix(world, task, given.part, given.value)
        return
    if task.side == "all" or not task.hold_outs:
        return
    parts, rows = _rows_of_side(world, board, task)
    row = rows[draws.bits(task.row_stream, 0) * len(rows) >> 32]
    for part, value in zip(parts, row, strict=True):
        _fix(world, task, part, value)


def _fix(world: World, task: ir.Task, part: ir.TaskPart, value: Value) -> None:
    """Gives a part a value. In a row of different values, the entry that has it gets the part's."""
    if part.place is None:
        world.fields[part.field] = value
        return
    row = list(world.fields[part.field])
    if _drawn(task, part).different and value in row:
        row[row.index(value)] = row[part.place]
    row[part.place] = value
    world.fields[part.field] = tuple(row)


def _drawn(task: ir.Task, part: ir.TaskPart) -> ir.Draw:
    draws = [statement for statement in task.draw.body if isinstance(statement, ir.Draw)]
    return next(drawn for drawn in draws if drawn.name == part.field)


_rows: dict[int, tuple[ir.Task, tuple[ir.TaskPart, ...], list[Row]]] = {}  # as `_training`


def _rows_of_side(
    world: World, board: Board, task: ir.Task
) -> tuple[tuple[ir.TaskPart, ...], list[Row]]:
    """Returns the parts that the conditions of a side read, and the values that they can have."""
    if id(task) not in _rows:
        hold_outs = [hold_out for hold_out in task.hold_outs if hold_out.name == task.split]
        is_held_out = task.side == "held_out" and bool(hold_outs)
        conditions = [h.condition for h in (hold_outs if is_held_out else task.hold_outs)]
        parts = parts_read(task, conditions)
        rows = []
        trial = copied(world)
        for row in _all_rows(task, parts):
            for part, value in zip(parts, row, strict=True):
                _fix(trial, task, part, value)
            instance = Instance(board, trial)
            if any(evaluate(condition, instance) for condition in conditions) == is_held_out:
                rows.append(row)
        _rows[id(task)] = task, parts, rows
    return _rows[id(task)][1:]


def _all_rows(task: ir.Task, parts: tuple[ir.TaskPart, ...]) -> Iterator[Row]:
    """Yields all that some parts can be, the last one changing first."""
    choices: list[Any] = []
    for part in parts:
        drawn = _drawn(task, part)
        whole = range(int(drawn.type.low), int(drawn.type.high) + 1) if not drawn.words else ()
        choices.append(drawn.words or whole)
    different = {d.name for d in task.draw.body if isinstance(d, ir.Draw) and d.different}
    for row in product(*choices):
        dealt = [(p.field, v) for p, v in zip(parts, row, strict=True) if p.field in different]
        if len(set(dealt)) == len(dealt):
            yield row


__all__ = ["fix_parts", "key_of_task"]

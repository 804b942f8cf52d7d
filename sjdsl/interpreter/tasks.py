"""The task of an episode: which key it is drawn from, and what a split says of its parts."""

from collections.abc import Callable, Iterator, Sequence
from functools import lru_cache
from itertools import chain, groupby, permutations, product
from operator import attrgetter
from weakref import WeakKeyDictionary

from sjdsl.compiler import ir
from sjdsl.compiler.ir.task_rows import drawn_field, parts_read
from sjdsl.interpreter.board import CACHE_SIZE, Board, declared_world
from sjdsl.interpreter.evaluate import evaluate
from sjdsl.interpreter.instance import Instance
from sjdsl.interpreter.state import Value, World, default_params
from sjdsl.interpreter.threefry import Draws, Threefry

Row = tuple[Value, ...]


def key_of_task(board: Board, draws: Draws, drawn: Callable[[Draws], World]) -> Draws:
    """Returns the key that the task of an episode is drawn from.

    drawn: returns a state with the task that is drawn from a key.
    """
    task = board.game.task
    assert task is not None
    train_on = task.train_on
    if task.given or train_on is None or task.side == "all":
        return draws
    stream = task.number_stream
    if task.side == "training":
        number = draws.bits(stream, 0) * train_on.number >> 32
        return Threefry(train_on.seed, number)
    if task.split != task.name:
        return draws
    training = _training_tasks(board, train_on, drawn)
    candidates = []
    for number in range(train_on.candidates):
        words = draws.bits(stream, 2 * number), draws.bits(stream, 2 * number + 1)
        candidates.append(Threefry(*words))
    for candidate in candidates:
        if _values(board, drawn(candidate)) not in training:
            return candidate
    return candidates[0]


# The tasks to train on of the boards in use. What draws a task is no part of the key.
_training: WeakKeyDictionary[Board, set[Row]] = WeakKeyDictionary()


def _training_tasks(
    board: Board, train_on: ir.TrainOn, drawn: Callable[[Draws], World]
) -> set[Row]:
    """Returns the values of all tasks to train on."""
    if board not in _training:
        worlds = [drawn(Threefry(train_on.seed, number)) for number in range(train_on.number)]
        _training[board] = {_values(board, world) for world in worlds}
    return _training[board]


def _values(board: Board, world: World) -> Row:
    task = board.game.task
    assert task is not None
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
    parts, rows = _rows_of_side(board)
    row = rows[draws.bits(task.row_stream, 0) * len(rows) >> 32]
    for part, value in zip(parts, row, strict=True):
        _fix(world, task, part, value)


def _fix(world: World, task: ir.Task, part: ir.TaskPart, value: Value) -> None:
    """Gives a part a value. In a row of different values, the entry that has it gets the part's."""
    if part.place is None:
        world.fields[part.field] = value
        return
    row = list(world.fields[part.field])
    if drawn_field(task, part.field).different and value in row:
        row[row.index(value)] = row[part.place]
    row[part.place] = value
    world.fields[part.field] = tuple(row)


@lru_cache(maxsize=CACHE_SIZE)
def _rows_of_side(board: Board) -> tuple[tuple[ir.TaskPart, ...], list[Row]]:
    """Returns the parts that the conditions of a side read, and the values that they can have."""
    task = board.game.task
    assert task is not None
    hold_outs = [hold_out for hold_out in task.hold_outs if hold_out.name == task.split]
    is_held_out = task.side == "held_out" and bool(hold_outs)
    conditions = [h.condition for h in (hold_outs if is_held_out else task.hold_outs)]
    parts = parts_read(task, conditions)
    rows = []
    trial = declared_world(board, default_params(board.game))
    for row in _all_rows(task, parts):
        for part, value in zip(parts, row, strict=True):
            _fix(trial, task, part, value)
        instance = Instance(board, trial)
        if any(evaluate(condition, instance) for condition in conditions) == is_held_out:
            rows.append(row)
    return parts, rows


def _all_rows(task: ir.Task, parts: Sequence[ir.TaskPart]) -> Iterator[Row]:
    """Yields all that some parts can be, the last one changing first."""
    of_fields: list[Iterator[Row]] = []
    for field, parts_of_field in groupby(parts, key=attrgetter("field")):
        number = len(list(parts_of_field))
        drawn = drawn_field(task, field)
        numbers = range(int(drawn.type.low), int(drawn.type.high) + 1) if not drawn.words else ()
        values: Sequence[Value] = drawn.words or numbers
        if drawn.different:
            of_fields.append(permutations(values, number))
        else:
            of_fields.append(product(values, repeat=number))
    for rows in product(*of_fields):
        yield tuple(chain.from_iterable(rows))


__all__ = ["fix_parts", "key_of_task"]

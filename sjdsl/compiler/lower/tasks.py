"""Lowers splits of tasks: the functions that draw a task of the side that is played."""

from sjdsl.compiler import ir
from sjdsl.compiler.ir.task_rows import (
    SideRows,
    drawn_field,
    drawn_fields,
    part_name,
    parts_of,
    rows_of_side,
)
from sjdsl.compiler.lower.beginning import begun
from sjdsl.compiler.lower.draws import KEY
from sjdsl.compiler.lower.writer import Module, Writer, replaced
from sjdsl.compiler.program import Function
from sjdsl.compiler.program.expressions import (
    Cast,
    Expression,
    Literal,
    Name,
    call,
    concatenated,
    live,
    path,
)

OF_SIDE = "task_of_side"
NUMBERS = "task_numbers"
STATE = Name("state")
ROW = Name("row")
PARAMS = Name("params")


def task_of_episode(task: ir.Task, module: Module) -> Expression:
    """Returns the state before `start`, with a task of the side that is played."""
    if _is_any(task):
        return _any_task(task)
    train_on = task.train_on
    key: Expression = KEY
    if train_on is not None and not task.given:
        stream = _stream("task_number", task.number_stream, module)
        tasks = (train_on.number, train_on.seed)
        if task.side == "training":
            key = call("numbered_key", KEY, stream, *tasks)
        elif _is_of_train_on(task):
            key = call("candidate_key", KEY, stream, train_on.candidates, Name(NUMBERS), *tasks)
    return call(OF_SIDE, PARAMS, key)


def functions_of_task(task: ir.Task, module: Module) -> list[Function]:
    """Returns the functions that `task_of_episode` calls, besides the phase of the task."""
    if _is_any(task):
        return []
    functions = [_task_of_side(task, module)]
    if _is_of_train_on(task):
        functions.append(_task_numbers(task, module))
    return functions


def _is_any(task: ir.Task) -> bool:
    """Returns whether an episode may have any task."""
    return task.side == "all" and not task.given


def _any_task(task: ir.Task) -> Expression:
    """Returns the state before `start`, with any task, which is drawn from `key`."""
    return begun(task.draw, call("initial_state"))


def _is_of_train_on(task: ir.Task) -> bool:
    """Returns whether what is played are the tasks that `train on` leaves."""
    return task.side == "held_out" and task.split == task.name and not task.given


def _stream(name: str, stream: int, module: Module) -> Literal:
    return module.number(f"stream_{name}", stream, group="stream")


def _task_of_side(task: ir.Task, module: Module) -> Function:
    """Returns the function `task_of_side(params, key)`, which draws a task of the side played.

    It draws any task, then one of the rows of values that the side has, and puts these in place.
    """
    w = Writer(module)
    w.set(STATE, _any_task(task))
    rows = rows_of_side(task)
    if rows.parts:
        comment = "rows of " + ", ".join(part_name(part, task) for part in rows.parts)
        numbers = []
        for row in rows.rows:
            values = zip(rows.parts, row, strict=True)
            numbers.append([_number(part, value, task) for part, value in values])
        table = module.constant("rows_of_side", numbers, comment, "i32")
        is_given = bool(task.given)
        stream = _stream("task_row", task.row_stream, module)
        w.set(ROW, table[0] if is_given else call("drawn_row", KEY, stream, table))
        w.set(STATE, replaced("state", _with_parts(rows, task)))
    w.give_back(STATE)
    doc = "Returns the state before `start` with a task of the side that is played."
    return Function(OF_SIDE, (("params", "Params"), ("key", "Array")), "State", doc, live(w.body))


def _number(part: ir.TaskPart, value: int | str, task: ir.Task) -> int:
    """Returns the number that stands for the value of a part."""
    if isinstance(value, int):
        return value
    return drawn_field(task, part.field).words.index(value)


def _with_parts(rows: SideRows, task: ir.Task) -> dict[str, Expression]:
    """Returns the attributes of State in which parts have the values of `row`."""
    changes: dict[str, Expression] = {}
    for drawn in drawn_fields(task):
        columns = [at for at, part in enumerate(rows.parts) if part.field == drawn.name]
        if not columns:
            continue
        attribute = f"world_{drawn.name}"
        if drawn.by is None:
            changes[attribute] = ROW[columns[0]]
            continue
        places = tuple(rows.parts[at].place for at in columns)
        values = ROW[columns[0] : columns[-1] + 1]
        different = {"different": True} if drawn.different else {}
        changes[attribute] = call(
            "with_entries", path(f"state.{attribute}"), values, places, **different
        )
    return changes


def _task_numbers(task: ir.Task, module: Module) -> Function:
    """Returns the function that returns all numbers of a task of the side."""
    w = Writer(module)
    w.set(STATE, call(OF_SIDE, call("default_params"), KEY))
    fields: list[Expression] = []
    for drawn in drawn_fields(task):
        value = path(f"state.world_{drawn.name}")
        fields.append(Cast(value, "i32") if drawn.by is not None else value[None])
    w.give_back(concatenated(fields))
    parts = sum(len(parts_of(drawn)) for drawn in drawn_fields(task))
    doc = f"Returns the task that is drawn from a key as numbers: `[{parts}]` int32."
    return Function(NUMBERS, (("key", "Array"),), "Array", doc, live(w.body))

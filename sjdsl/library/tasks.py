"""Which tasks of a game are played: a side of its splits, or those with some parts fixed."""

from collections.abc import Mapping
from typing import Any

from sjdsl.compiler import ir
from sjdsl.compiler.ir.task_rows import drawn_fields, part_name, parts_of, values_of
from sjdsl.interpreter.step import task_of_key
from sjdsl.library.parameters import plain_number
from sjdsl.near_names import meant

Tasks = str | Mapping[str, Any]  # `training`, `held_out`, `all`, or values by field
SIDES = ("training", "held_out", "all")
ARGUMENTS = ("tasks", "split", "problem")  # of `sjdsl.make`: together they are one choice
MAX_PROBLEM = 2**32 - 1


def with_tasks(
    game: ir.Game, tasks: Tasks | None = None, split: str | None = None, problem: int | None = None
) -> ir.Game:
    """Returns a game that plays some of its tasks, whichever it played before.

    Args:
      tasks: `training`, `held_out`, `all`, or the values of some fields by name, where an entry of
        a row is `pay[red]`, or `{"pay": {"red": 3}}`; all others are drawn. By default the training
        tasks, if the game has a split, else all.
      split: which tasks are held out, where the game has several splits: the name of a `hold out`,
        or that of the task for the tasks that `train on` leaves.
      problem: plays the one task that the key of this number gives among those.

    Raises:
      ValueError: the game has no task, no split, or not these fields, values, or split.
      TypeError: an argument is of a wrong type.
    """
    _check_types(tasks, split, problem)
    task = game.task
    if task is None:
        if tasks is None and split is None and problem is None:
            return game
        raise ValueError(
            f"{game.name} has no task: leave out tasks, split and problem, or declare one, "
            "`task rules { field hue : { red, green } }`"
        )
    if isinstance(tasks, Mapping):
        if split is not None:
            raise ValueError("fields of a task are fixed whichever side is played: leave out split")
        changes: dict[str, Any] = {"side": "all", "split": "", "given": _given(task, tasks)}
    else:
        changes = {**_side(task, tasks, split), "given": ()}
    chosen = game.model_copy(update={"task": task.model_copy(update=changes)})
    if problem is None:
        return chosen
    return _with_values(chosen, task_of_key(chosen, (0, problem)))


def replaced_tasks(arguments: Mapping[str, Any], choice: Mapping[str, Any]) -> dict[str, Any]:
    """Returns arguments of `sjdsl.make` with another choice of tasks, unless that is empty.

    choice: those of `tasks`, `split` and `problem` that have a value; they replace all three.
    """
    if not choice:
        return dict(arguments)
    others = {name: value for name, value in arguments.items() if name not in ARGUMENTS}
    return {**others, **choice}


def _check_types(tasks: Any, split: Any, problem: Any) -> None:
    if not isinstance(tasks, str | Mapping | None):
        raise TypeError(
            f"tasks is {_listed(SIDES)}, or a mapping from fields of the task to values, "
            f"not {tasks!r}"
        )
    if not isinstance(split, str | None):
        raise TypeError(f"a split is a name, not {split!r}")
    if problem is None:
        return
    if isinstance(problem, bool) or not isinstance(problem, int):
        raise TypeError(f"a problem is a whole number, not {problem!r}")
    if not 0 <= problem <= MAX_PROBLEM:
        raise ValueError(f"a problem is a number from 0 to {MAX_PROBLEM}, not {problem}")


def splits_of(task: ir.Task) -> tuple[str, ...]:
    """Returns the names of the splits: that of the task if there is a `train on`, and hold-outs."""
    names = () if task.train_on is None else (task.name,)
    return (*names, *(hold_out.name for hold_out in task.hold_outs))


def _side(task: ir.Task, side: str | None, split: str | None) -> dict[str, Any]:
    """Returns what a task says of the side that is played."""
    names = splits_of(task)
    if split is not None and split not in names:
        raise ValueError(f"the task has no split `{split}`{meant(split, names, 'it has')}")
    if side is None:
        side = "training" if names else "all"
    if side not in SIDES:
        raise ValueError(
            f"tasks is {_listed(SIDES)}, or a mapping from fields of the task to values, "
            f"not {side!r}{meant(side, SIDES, 'the sides are')}"
        )
    if side != "all" and not names:
        raise ValueError(
            f"the task `{task.name}` has no split, so there are no {side} tasks: play all, or "
            f"write `train on 64 of {task.name} seed 0`"
        )
    if side != "held_out":
        if split is not None:
            raise ValueError(f"a split says which tasks are held out, and {side} are played")
        return {"side": side, "split": ""}
    if split is None and len(names) > 1:
        raise ValueError(
            f"the task has several splits, {', '.join(names)}: say by split which tasks are held out"
        )
    return {"side": side, "split": split or names[0]}


def _given(task: ir.Task, values: Mapping[str, Any]) -> tuple[ir.GivenPart, ...]:
    """Returns the parts with these values, in the order of declaration."""
    wanted: dict[str, Any] = {}
    for name, value in values.items():
        if not isinstance(name, str):
            raise TypeError(f"tasks has names of fields of the task, not {name!r}")
        if isinstance(value, Mapping):
            for key, entry in value.items():
                _add(wanted, f"{name}[{key}]", entry)
        else:
            _add(wanted, name.replace(" ", ""), value)
    fields = {drawn.name: drawn for drawn in drawn_fields(task)}
    known: dict[str, ir.TaskPart] = {}
    for drawn in fields.values():
        known |= {part_name(part, task): part for part in parts_of(drawn)}
    for name in wanted:
        if name not in known:
            raise ValueError(_not_a_part(name, fields, known))
    given = []
    for name, part in known.items():
        if name in wanted:
            value = _value(name, wanted[name], fields[part.field])
            given.append(ir.GivenPart(name=name, part=part, value=value))
    _check_different(given, task)
    return tuple(given)


def _add(wanted: dict[str, Any], name: str, value: Any) -> None:
    if name in wanted:
        raise ValueError(f"`{name}` is given twice; give it once")
    wanted[name] = value


def _not_a_part(name: str, fields: Mapping[str, ir.Draw], known: Mapping[str, Any]) -> str:
    """Returns why a name is no part of the task."""
    field = name.partition("[")[0]
    if field not in fields:
        return f"the task has no field `{field}`{meant(field, list(fields), 'it has')}"
    by = fields[field].by
    if by is None:
        return f"`{field}` of the task is one value, not a row"
    entries = [other for other in known if other.startswith(f"{field}[")]
    if name == field:
        return f"`{field}` of the task is a row: give its entries by name, {', '.join(entries)}"
    return f"`{name}` is no entry of the task{meant(name, entries, 'it has')}"


def _value(name: str, value: Any, drawn: ir.Draw) -> int | str:
    """Returns the checked value of a part."""
    value = plain_number(value)
    values = values_of(drawn)
    is_truth = isinstance(value, bool)
    if is_truth or value not in values:
        if drawn.words:
            raise ValueError(f"`{name}` is one of {', '.join(drawn.words)}, not {value!r}")
        raise ValueError(f"`{name}` is a whole number, {values[0]} .. {values[-1]}, not {value!r}")
    return value if isinstance(value, str) else int(value)


def _check_different(given: list[ir.GivenPart], task: ir.Task) -> None:
    """Raises ValueError if entries of a row of different values get the same one."""
    different = {drawn.name for drawn in drawn_fields(task) if drawn.different}
    first: dict[tuple[str, int | str], ir.GivenPart] = {}
    for one in given:
        if one.part.field not in different:
            continue
        other = first.setdefault((one.part.field, one.value), one)
        if other is not one:
            raise ValueError(
                f"`{other.name}` and `{one.name}` are both {one.value}: "
                "the entries of this row are different"
            )


def _with_values(game: ir.Game, values: Mapping[str, Any]) -> ir.Game:
    """Returns a game that plays one task. values: of each field, that of a row as a tuple."""
    assert game.task is not None
    given = []
    for drawn in drawn_fields(game.task):
        entries = (values[drawn.name],) if drawn.by is None else values[drawn.name]
        for part, value in zip(parts_of(drawn), entries, strict=True):
            name = part_name(part, game.task)
            given.append(ir.GivenPart(name=name, part=part, value=value))
    changes = {"given": tuple(given), "side": "all", "split": ""}
    return game.model_copy(update={"task": game.task.model_copy(update=changes)})


def _listed(names: tuple[str, ...]) -> str:
    return ", ".join(f"`{name}`" for name in names)

"""Elaborates the splits of a task: tasks to learn from, and those held out.

train on 64 of rules seed 0   ->   TrainOn(number=64, seed=0)
hold out light of rules where pay[red] > 7   ->   HoldOut(name="light", condition=…)
"""

from sjdsl.compiler import ast, ir
from sjdsl.compiler.ast.names import Symbol
from sjdsl.compiler.compose import Composition
from sjdsl.compiler.diagnostics import errors, limits
from sjdsl.compiler.elaborate.scope import Scope
from sjdsl.compiler.ir.fold import VALUES
from sjdsl.compiler.ir.task_rows import (
    holds_out_any,
    number_of_ways,
    part_name,
    parts_read,
    rows_of_training,
    tasks_with,
)

WORLD = ir.EntityType("world")
# All candidates are training tasks with a probability of 2^-64 at most. Half of the tasks or more
# are no training tasks of `train on`, so there are 64 candidates at most.
BITS = 64


def check_no_splits(game: Composition, scope: Scope) -> None:
    """Reports splits in a game without a task."""
    for split in _written(game):
        scope.problems.add(errors.SplitOfNothing(split.span, name=split.task.text))


def with_splits(task: ir.Task, game: Composition, scope: Scope) -> ir.Task:
    """Returns a task with the splits of the file."""
    static = scope.static
    for split in _written(game):
        if split.task.text != task.name:
            with scope.problems.skip_if_broken():
                raise scope.problems.unknown(split.task, [task.name], "the task")
    before = len(scope.problems.diagnostics)
    hold_outs = []
    for split in game.held_out.values():
        static.refer(split.name, Symbol("split", split.name.text))
        with scope.problems.skip_if_broken():
            hold_outs.append(_hold_out(split, task, scope))
    if len(scope.problems.diagnostics) > before:
        return task
    task = task.changed(hold_outs=tuple(hold_outs))
    with scope.problems.skip_if_broken():
        _check_conditions(task, scope)
        training = rows_of_training(task)
        if not training.rows:
            raise scope.fail(errors.NothingToTrainOn(task.hold_outs[-1].span))
        if game.train_on is not None:
            train_on = _train_on(game.train_on, tasks_with(training, task), scope)
            task = task.changed(train_on=train_on)
    return task


def _written(game: Composition) -> list[ast.TrainOn | ast.HoldOut]:
    """Returns the splits of a file."""
    splits: list[ast.TrainOn | ast.HoldOut] = list(game.held_out.values())
    if game.train_on is not None:
        splits.append(game.train_on)
    return splits


def _hold_out(split: ast.HoldOut, task: ir.Task, scope: Scope) -> ir.HoldOut:
    """Returns a typed `hold out`; reports a condition that reads more than fields of the task."""
    name = split.name.text
    if name == task.name:
        raise scope.fail(errors.NameTaken(split.name.span, name=name, taken_by="the task"))
    condition = scope.condition(split.condition)
    for node in ir.walk(condition):
        if isinstance(node, ir.FieldRead) and node.held_by == WORLD and node.name in task.fields:
            continue
        if ir.is_expression(node) and type(node) not in VALUES:
            raise scope.fail(errors.SplitReads(node.origin or split.condition.span, name=name))
    return ir.HoldOut(name=name, condition=condition, origin=split.span)


def _check_conditions(task: ir.Task, scope: Scope) -> None:
    """Reports conditions that read too much to list the cases, and one that never holds."""
    conditions = [hold_out.condition for hold_out in task.hold_outs]
    parts = parts_read(task, conditions)
    ways = number_of_ways(task, parts)
    if ways > limits.MAX_DRAWN:
        names = ", ".join(part_name(part, task) for part in parts)
        problem = f"what is held out depends on {names}: {ways} cases"
        help_ = "let the conditions read fewer fields, or entries of rows by name"
        span = task.hold_outs[-1].span
        raise scope.fail(limits.too_much(problem, limits.MAX_DRAWN, span, help_))
    for hold_out in task.hold_outs:
        if not holds_out_any(task, hold_out):
            raise scope.fail(errors.NothingHeldOut(hold_out.span, name=hold_out.name))


def _train_on(split: ast.TrainOn, tasks: int, scope: Scope) -> ir.TrainOn:
    """Returns what to train on, of this many tasks that no `hold out` holds out."""
    quantity = "the number of tasks to train on"
    number = scope.whole(split.number, quantity, quantity, 1, limits.MAX_DRAWN)
    quantity = "the seed of a split"
    seed = scope.whole(split.seed, quantity, quantity, 0, limits.MAX_VALUE)
    if 2 * number > tasks:
        raise scope.fail(
            errors.TooManyToTrainOn(split.number.span, number=number, tasks=tasks, most=tasks // 2)
        )
    candidates = _candidates(number, tasks)
    return ir.TrainOn(number=number, seed=seed, candidates=candidates, origin=split.span)


def _candidates(number: int, tasks: int) -> int:
    """Returns the smallest A with (number / tasks)^A <= 2^-64."""
    candidates = 1
    while number**candidates << BITS > tasks**candidates:
        candidates += 1
    return candidates

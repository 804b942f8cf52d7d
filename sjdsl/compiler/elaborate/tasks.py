"""Elaborates a task: fields of the world that are drawn for each episode.

task rules { field hue : { red, green } }   ->   Task(draw=phase { draw hue from …  set hue = hue })
"""

from sjdsl.compiler import ast, ir
from sjdsl.compiler.ast.names import Symbol, field_symbol
from sjdsl.compiler.compose import Composition
from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.tree import walk
from sjdsl.compiler.elaborate.fields import field_type
from sjdsl.compiler.elaborate.keys import index_set_of
from sjdsl.compiler.elaborate.scope import Scope
from sjdsl.compiler.elaborate.splits import check_no_splits, with_splits
from sjdsl.compiler.elaborate.statements import check_deal, check_number_of_values
from sjdsl.compiler.elaborate.streams import Streams

WORLD = ir.EntityType("world")


def declare_task(game: Composition, scope: Scope) -> None:
    """Adds the fields of the task to those of the world."""
    static = scope.static
    for number, task in enumerate(game.tasks.values()):
        if number:
            scope.problems.add(errors.SecondTask(task.name.span, name=task.name.text))
        for field in task.fields:
            with scope.problems.skip_if_broken(static.broken, Symbol("name", field.name.text)):
                static.fields[field.name.text] = _declared(field, scope)
                static.task_fields.add(field.name.text)


def _declared(field: ast.TaskField, scope: Scope) -> ir.VarField:
    """Returns the field of a task."""
    if not isinstance(field.type, ast.Words | ast.Range):
        raise scope.expected(field.type.span, "words or a range of numbers", "another type")
    type_ = field_type(field.type, scope)
    start = type_.words[0] if type_.kind == "word" else int(type_.low)
    if field.by is not None:
        type_ = type_.changed(indexed_by=(index_set_of(field.by, scope),))
    name = field.name.text
    if any(isinstance(node, ast.Path) for node in walk(field.type)):
        scope.static.sized.add(field_symbol(name, WORLD.name))
    return ir.VarField(name=name, held_by=WORLD, type=type_, start=start, origin=field.span)


def task(game: Composition, scope: Scope) -> ir.Task | None:
    """Returns the task of a game; None if it has none."""
    static = scope.static
    for declared in game.tasks.values():
        streams = Streams(f"task {declared.name.text}", static.sources)
        body: list[ir.Stmt] = []
        for field in declared.fields:
            if field.name.text in static.task_fields:
                with scope.problems.skip_if_broken():
                    body += _drawn(field, streams, scope)
        draw = ir.Phase(
            label=streams.label, name="draw_task", body=tuple(body), origin=declared.span
        )
        typed = ir.Task(
            name=declared.name.text,
            fields=tuple(field.name.text for field in declared.fields),
            draw=draw,
            number_stream=streams.shared("split", "number"),
            row_stream=streams.shared("split", "row"),
            origin=declared.span,
        )
        is_whole = len(body) == 2 * len(declared.fields)  # a draw and a `set` for each field
        return with_splits(typed, game, scope) if is_whole else typed
    check_no_splits(game, scope)
    return None


def _drawn(field: ast.TaskField, streams: Streams, scope: Scope) -> tuple[ir.Draw, ir.Set]:
    """Returns the statements that draw a field and set it."""
    name = field.name.text
    type_ = scope.static.fields[name].type
    low = high = None
    if type_.kind == "int":
        one = type_.changed(indexed_by=())
        low = ir.Number(type=one, value=int(one.low))
        high = ir.Number(type=one, value=int(one.high))
    draw = ir.Draw(
        name=name,
        type=type_,
        low=low,
        high=high,
        words=type_.words,
        by=type_.indexed_by[0] if type_.indexed_by else None,
        different=field.different,
        stream=streams.of_line(field.span),
        origin=field.span,
    )
    if type_.kind == "int":
        check_number_of_values(type_, field.span, scope, "write a smaller range")
    if field.different:
        check_deal(draw, field.span, scope)
    read = ir.FieldRead(type=type_, owner=None, held_by=WORLD, name=name, origin=field.span)
    value = ir.Local(type=type_, name=name, origin=field.span)
    return draw, ir.Set(target=read, value=value, origin=field.span)


def check_not_told(agents: ir.Agents, shown: tuple[ir.Observable, ...], scope: Scope) -> None:
    """Reports each `forbid` that reads a field of the task which agents don't see."""
    seen = {o.field for o in shown if o.what == "world" and o.shown_when is None}
    hidden = scope.static.task_fields - seen
    for forbid in agents.forbids:
        reads = [node for node in ir.walk(forbid) if isinstance(node, ir.FieldRead)]
        for read in reads:
            if read.held_by == WORLD and read.name in hidden:
                scope.problems.add(errors.TaskTold(read.span, name=read.name))

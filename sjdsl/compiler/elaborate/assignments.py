"""Elaborates `set` and `add`: the value fits the field, and provably stays in its range."""

from dataclasses import replace
from math import inf

from sjdsl.compiler import ast, ir
from sjdsl.compiler.diagnostics import errors, limits
from sjdsl.compiler.diagnostics.problems import Poisoned
from sjdsl.compiler.diagnostics.source import Span
from sjdsl.compiler.elaborate.fitting import check_number, fitting_value
from sjdsl.compiler.elaborate.lookup import declared_name, interval_text, is_agent, read_beside
from sjdsl.compiler.elaborate.movers import check_heading
from sjdsl.compiler.elaborate.scope import Scope, wrong_type
from sjdsl.compiler.elaborate.streams import Streams
from sjdsl.compiler.elaborate.trials import TRIAL
from sjdsl.compiler.ir.implications import narrowed
from sjdsl.compiler.ir.printer import expression_text as text
from sjdsl.compiler.ir.queries import written_field
from sjdsl.compiler.ir.range_arithmetic import FLOAT32, Range
from sjdsl.compiler.ir.types import describe, has_limits, is_number

BOUND_BOTH = "guard the change with `when`, or bound it with `min` and `max`"
# times that one statement can add to a field, in `each cell { each agent { … } }`
MOST_ADDED = limits.MAX_MAP_CELLS * limits.MAX_AGENTS
ONLY_ADD = "only `add` stops at the end of a range that is `capped`"


def target_of(path: ast.Path, scope: Scope) -> tuple[ir.Expr, ir.VarField]:
    """Returns the field (or entry of a row) a statement writes, and its declaration."""
    target = scope.expression(path)
    field = target
    while isinstance(field, ir.At):
        field = field.row
    if isinstance(field, ir.FieldRead):
        is_of_world = field.held_by.what == "world"
        if scope.static.has_trials and is_of_world and field.name == TRIAL:
            raise scope.fail(errors.TrialIsCounted(path.span))
        if is_of_world and field.name in scope.static.task_fields:
            raise scope.fail(errors.TaskWritten(path.span, name=field.name))
        return target, scope.static.fields_of(field.held_by)[field.name]
    match field:
        case ir.Attribute(
            name="row" | "col", owner=ir.Member(entity_type=ir.EntityType("mover", (name,)))
        ):
            help_ = (
                f"movers change their places by `move each {name} ahead` or another course, "
                f"and by `send {name} to KIND`"
            )
        case ir.Attribute(name="row" | "col"):
            help_ = "agents change their places by `move` and by `send agent to KIND`"
        case ir.Attribute(name="heading"):
            help_ = "write `set`: a heading is a word"
        case ir.ParamRef() | ir.Number():
            help_ = (
                "numbers stay as they are; what changes is a field, "
                "such as `field pot : 0 .. 9 = 0`"
            )
        case _:
            help_ = "only fields can be written"
    raise scope.expected(path.span, "a field", describe(target.type), help_)


def _target_beside(s: ast.Set | ast.Add, scope: Scope) -> tuple[ir.Expr, ir.VarField]:
    """Returns what a statement writes; if that is wrong, reports the mistakes in the value too."""
    try:
        return target_of(s.target, scope)
    except Poisoned:
        read_beside(s.value, scope)
        raise


def set_(s: ast.Set, scope: Scope, streams: Streams) -> ir.Stmt:
    """Returns `set target = value` or `set target = value by lot`."""
    if _is_heading(s.target, scope):
        return _face(s, scope)
    target, field = _target_beside(s, scope)
    value = fitting_value(s.value, target, target.type, scope)
    if target.type.kind == "real" and has_limits(target.type):
        reached = scope.computed_range(value)
        if not _is_within(reached, target.type):
            help_ = _instead_of_set(s, field, target, scope) or BOUND_BOTH
            raise _leaves_reals(s.value.span, target, reached, scope, help_)
    if target.type.kind == "int":
        low, high = narrowed(value, scope.facts)
        limit = inf if field.timer else target.type.high
        if low < target.type.low or high > limit:
            help_ = _instead_of_set(s, field, target, scope)
            interval = interval_text(low, high)
            raise _leaves_range(errors.FieldRange, s.value.span, target, interval, scope, help_)
    lot = None
    if s.lot is not None:
        if s.lot.text != "lot":
            raise scope.problems.unknown(s.lot, ("lot",), "what may follow `by` here")
        lot = streams.of_line(s.span)
    return ir.Set(target=target, value=value, lot=lot, origin=s.span)


def _is_heading(path: ast.Path, scope: Scope) -> bool:
    """Returns whether a path ends in `.heading`, and that is the heading of an agent."""
    last = path.steps[-1] if path.steps else None
    if not isinstance(last, ast.Member) or last.name.text != "heading":
        return False
    try:
        return isinstance(scope.expression(path), ir.Attribute)
    except Poisoned:
        return False  # it is read once more, and its mistakes are reported once


def _face(s: ast.Set, scope: Scope) -> ir.Face:
    """Returns `set agent.heading = value`."""
    heading = scope.expression(s.target)
    assert isinstance(heading, ir.Attribute)
    if s.lot is not None:
        wanted = "the end of the statement"
        help_ = "let one rule turn an agent, or draw a heading first and set it"
        raise scope.expected(s.lot.span, wanted, "`by lot`", help_)
    value = scope.narrowed(s.value)
    wanted = "a heading (`north`, `east`, `south` or `west`)"
    check_heading(value, s.value, wanted, scope)
    return ir.Face(who=heading.owner, heading=value, origin=s.span)


def _instead_of_set(s: ast.Set, field: ir.VarField, target: ir.Expr, scope: Scope) -> str:
    """Returns what to write in place of a `set` that can leave a range that is `capped`."""
    if not field.capped:
        return ""
    match s.value:
        case ast.Binary(op="+", left=ast.Path() as left, right=right):
            path = text(target)
            if text(scope.expression(left)) == path:
                return f"{ONLY_ADD}: write `add {scope.static.written(right.span)} to {path}`"
    return f"{ONLY_ADD}: {BOUND_BOTH}"


def _check_capped_alike(s: ast.Add, target: ir.Expr, scope: Scope) -> None:
    """Reports an `add` to a field of a group that is `capped` in some of its kinds only."""
    field = written_field(target)
    if field.held_by.what != "cell":
        return
    capped = [k for k in field.held_by.names if scope.static.kinds[k][field.name].capped]
    if capped and len(capped) < len(field.held_by.names):
        wanted = "a field that is `capped` in every kind of the group, or in none"
        actual = f"one that is capped in {', '.join(f'`{kind}`' for kind in capped)} only"
        raise scope.expected(s.target.span, wanted, actual)


def add(s: ast.Add, scope: Scope) -> ir.Stmt:
    """Returns `add value to target`: a number, a row to a row, an agent to a set."""
    target, field = _target_beside(s, scope)
    value = scope.expression(s.value)
    if target.type.kind == "agents":
        if not is_agent(value):
            raise wrong_type(scope, s.value, "an agent", value.type)
        return ir.Add(target=target, value=value, origin=s.span)
    if target.type.kind not in ("int", "real") or field.timer:
        wanted = "a number, a row of numbers or a set of agents"
        help_ = "a timer is `set`; it falls at `tick`" if field.timer else ""
        raise wrong_type(scope, s.target, wanted, target.type, help_)
    if value.type.indexed_by != target.type.indexed_by:
        raise wrong_type(scope, s.value, describe(target.type), value.type)
    _check_capped_alike(s, target, scope)
    check_number(s.value, target.type, value, scope)
    if target.type.kind == "real" and has_limits(target.type):
        _check_added_real(s, target, value, field.capped, scope)
    if target.type.kind == "int" and not field.capped:  # no other statement then adds to it
        low = target.type.low
        high = target.type.high
        if is_number(target.type):
            low, high = narrowed(target, scope.facts)
        low += value.type.low
        high += value.type.high
        if low < target.type.low or high > target.type.high:
            interval = interval_text(low, high)
            raise _leaves_range(errors.FieldRange, s.span, target, interval, scope)
    return ir.Add(target=target, value=value, origin=s.span)


def _check_added_real(
    s: ast.Add, target: ir.Expr, value: ir.Expr, capped: bool, scope: Scope
) -> None:
    """Reports an `add` of reals that can leave the range of a field.

    That of a `capped` one must be a number, however often it is added.
    """
    if capped:
        added = scope.computed_range(value)
        if not added.sound or added.largest * MOST_ADDED > FLOAT32:
            raise _leaves_reals(s.value.span, target, replace(added, sound=False), scope)
        return
    type_ = ir.Type(kind="real", unit=target.type.unit, indexed_by=target.type.indexed_by)
    total = ir.Arithmetic(type=type_, fn="+", args=(target, value))
    reached = scope.computed_range(total)
    if not _is_within(reached, target.type):
        raise _leaves_reals(s.span, target, reached, scope)


def _is_within(reached: Range, type_: ir.Type) -> bool:
    return reached.sound and type_.low <= reached.low and reached.high <= type_.high


def _leaves_reals(
    span: Span, target: ir.Expr, reached: Range, scope: Scope, help_: str = ""
) -> Poisoned:
    """Reports a real that can leave the range of a field, or float32."""
    interval = f"{reached.low:.9g} .. {reached.high:.9g}"
    if reached.sound:
        return _leaves_range(errors.FieldRange, span, target, interval, scope, help_)
    return _leaves_range(errors.LeavesFloat32InField, span, target, interval, scope)


def _leaves_range(
    problem: type[errors.FieldRange],
    span: Span,
    target: ir.Expr,
    reached: str,
    scope: Scope,
    help_: str = "",
) -> Poisoned:
    """Reports a value that can be outside the range of the field it is written to."""
    return scope.fail(
        problem(
            span,
            name=text(target),
            declared=declared_name(target),
            low=target.type.low,
            high=target.type.high,
            reached=reached,
            help=help_,
        )
    )

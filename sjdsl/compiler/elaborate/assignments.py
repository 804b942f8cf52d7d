"""Elaborates `set` and `add`: the value fits the field, and provably stays in its range."""

from math import inf

from sjdsl.compiler import ast, ir
from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.problems import Poisoned
from sjdsl.compiler.diagnostics.source import Span
from sjdsl.compiler.elaborate.lookup import as_agent, check_known_word, declared_name, interval_text, kinds_of_cell, not_a_word, or_nowhere
from sjdsl.compiler.elaborate.scope import Scope, wrong_type
from sjdsl.compiler.elaborate.streams import PhaseUse
from sjdsl.compiler.ir.implications import narrow_word, narrowed
from sjdsl.compiler.ir.printer import expression as text
from sjdsl.compiler.ir.types import describe, is_number, join_units


def target_of(path: ast.Path, scope: Scope) -> tuple[ir.Expr, ir.VarField]:
    """Returns the field (or entry of a row) a statement writes, and its declaration."""
    target = scope.expression(path)
    field = target
    while isinstance(field, ir.At):
        field = field.row
    if not isinstance(field, ir.FieldRead):
        raise scope.problems.fail(errors.WrongType(path.span, wanted="a field", given=describe(target.type), help=_written_how(field)))
    return target, declaration(field, scope)


def _written_how(e: ir.Expr) -> str:
    """Returns how what is no field changes."""
    match e:
        case ir.Attribute(name="row" | "col", owner=ir.Member(sort=ir.Sort("mover", (sort,)))):
            return f"movers change their places by `move each {sort} ahead` and the like, and by `send {sort} to KIND`"
        case ir.Attribute(name="row" | "col"):
            return "agents change their places by `move` and by `send agent to KIND`"
        case ir.Attribute(name="heading"):
            return "agents turn by their actions, and where they are sent: `send agent to KIND facing north`"
        case ir.ParamRef() | ir.Number():
            return "numbers stay as they are; what changes is a field, such as `field pot : 0 .. 9 = 0`"
        case _:
            return "only fields can be written"


def declaration(field: ir.FieldRead, scope: Scope) -> ir.VarField:
    static = scope.static
    match field.held_by.what:
        case "world":
            return static.fields[field.name]
        case "agent":
            return static.agent_fields[field.name]
        case "mover":
            return static.mover_fields(field.held_by.name)[field.name]
        case "cell":
            return static.kinds[field.held_by.names[0]][field.name]


def set_(s: ast.Set, scope: Scope, use: PhaseUse) -> ir.Stmt:
    """Returns `set target = value` or `set target = value by lot`."""
    target, field = target_of(s.target, scope)
    if target.type.kind == "word":
        check_known_word(s.value, target, target.type.words, scope)
    value = narrow_word(scope.expression(s.value), scope.facts)
    type_ = target.type
    if value.type.by and value.type.by != type_.by:
        raise wrong_type(scope, s.value, describe(type_), value.type)
    match type_.kind:
        case "word":
            _check_words(s, type_, target, value, scope)
        case "int" | "real":
            _check_number(s, field, target, value, scope)
        case "agent":
            if not as_agent(value):
                raise wrong_type(scope, s.value, "an agent or nobody", value.type)
        case "cell":
            value = or_nowhere(value)
            kinds = value.type.kinds if value.type.kind == "cell" else kinds_of_cell(value)  # a row of cells, too
            if kinds is None or not set(kinds) <= set(type_.kinds):
                given = value.type if kinds is None else ir.Type(kind="cell", kinds=kinds)
                raise wrong_type(scope, s.value, f"{describe(type_)} or nowhere", given)
        case "agents":
            if not isinstance(value, ir.Nobody) and value.type.kind != "agents":
                raise wrong_type(scope, s.value, "a set of agents or nobody", value.type)
        case _:
            raise AssertionError(type_)
    return ir.Set(target=target, value=value, lot=_lot(s, scope, use), origin=s.span)


def _lot(s: ast.Set, scope: Scope, use: PhaseUse) -> int | None:
    """Returns the stream on which it is drawn who writes."""
    if s.lot is None:
        return None
    if s.lot.text != "lot":
        raise scope.problems.unknown(s.lot, ("lot",), "what may follow `by` here")
    return use.streams.of_statement(use.streams.header(s.span, s.span.end))


def _check_words(s: ast.Set, type_: ir.Type, target: ir.Expr, value: ir.Expr, scope: Scope) -> None:
    if value.type.kind != "word":
        raise wrong_type(scope, s.value, describe(type_), value.type)
    for word in value.type.words:
        if word not in type_.words:
            raise not_a_word(s.value.span, word, target, type_.words, scope)


def _check_number(s: ast.Set, field: ir.VarField, target: ir.Expr, value: ir.Expr, scope: Scope) -> None:
    _check_unit(s.value, target, value, scope)
    if target.type.kind == "int" and value.type.kind != "int":
        raise wrong_type(scope, s.value, "a whole number", value.type)
    low, high = narrowed(value, scope.facts)
    limit = inf if field.timer else target.type.high
    if target.type.kind == "int" and (low < target.type.low or high > limit):
        raise _leaves_range(s.value.span, target, (low, high), value, scope, _instead_of_set(s, field, target, scope))


def _instead_of_set(s: ast.Set, field: ir.VarField, target: ir.Expr, scope: Scope) -> str:
    """Returns what to write where a `set` is to stop at the end of a range that is `capped`: only `add` does."""
    if not field.capped:
        return ""
    match s.value:
        case ast.Binary(op="+", left=ast.Path() as left, right=right) if text(scope.expression(left)) == text(target):
            added = scope.static.sources[right.span.file].text[right.span.start : right.span.end]
            return f"only `add` stops at the end of a range that is `capped`: write `add {added} to {text(target)}`"
    return "only `add` stops at the end of a range that is `capped`: guard the change with `when`, or bound it with `min` and `max`"


def _check_unit(tree: ast.Expr, target: ir.Expr, value: ir.Expr, scope: Scope) -> None:
    if value.type.kind not in ("int", "real"):
        raise wrong_type(scope, tree, describe(target.type), value.type)
    if join_units(target.type.unit, value.type.unit) is None:
        raise scope.problems.fail(
            errors.UnitMismatch(tree.span, verb="put into one field", left=describe(target.type), right=describe(value.type))
        )


def add(s: ast.Add, scope: Scope) -> ir.Stmt:
    """Returns `add value to target`: a number, a row to a row, an agent to a set."""
    target, field = target_of(s.target, scope)
    value = scope.expression(s.value)
    if target.type.kind == "agents":
        if not as_agent(value):
            raise wrong_type(scope, s.value, "an agent", value.type)
        return ir.Add(target=target, value=value, origin=s.span)
    if target.type.kind not in ("int", "real") or field.timer:
        help_ = "a timer is `set`; it falls at `tick`" if field.timer else ""
        raise wrong_type(scope, s.target, "a number, a row of numbers or a set of agents", target.type, help_)
    if value.type.by != target.type.by:
        raise wrong_type(scope, s.value, describe(target.type), value.type)
    _check_unit(s.value, target, value, scope)
    if target.type.kind == "int" and value.type.kind != "int":
        raise wrong_type(scope, s.value, "a whole number", value.type)
    if target.type.kind == "int" and not field.capped:
        _check_added(s, target, value, scope)
    return ir.Add(target=target, value=value, origin=s.span)


def _check_added(s: ast.Add, target: ir.Expr, value: ir.Expr, scope: Scope) -> None:
    """Without `capped` an add must stay in range by what the guards say, and be the only one that reaches its target."""
    low, high = narrowed(target, scope.facts) if is_number(target.type) else (target.type.low, target.type.high)
    reached = (low + value.type.low, high + value.type.high)
    inside = target.type.low <= reached[0] and reached[1] <= target.type.high
    if not inside:
        raise _leaves_range(s.span, target, reached, value, scope)


def _leaves_range(span: Span, target: ir.Expr, reached: tuple[float, float], value: ir.Expr, scope: Scope, help_: str = "") -> Poisoned:
    becomes = interval_text(value.type.model_copy(update={"low": reached[0], "high": reached[1]}))
    name, declared, low, high = text(target), declared_name(target), target.type.low, target.type.high
    found = errors.FieldRange(span, name=name, declared=declared, low=low, high=high, reached=becomes, help=help_)
    return scope.problems.fail(found)

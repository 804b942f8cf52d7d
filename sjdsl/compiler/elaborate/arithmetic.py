"""Elaborates arithmetic and comparison: refuses units that do not mix, such as reward and steps; intervals of results."""

from sjdsl.compiler import ast, ir
from sjdsl.compiler.diagnostics import errors, limits
from sjdsl.compiler.diagnostics.problems import Poisoned
from sjdsl.compiler.diagnostics.source import Span
from sjdsl.compiler.elaborate.declaration_labels import parameters_read
from sjdsl.compiler.elaborate.domains import can_be_empty
from sjdsl.compiler.elaborate.scope import Scope, wrong_type
from sjdsl.compiler.ir.evaluate_constant import fold
from sjdsl.compiler.ir.implications import compares, narrowed
from sjdsl.compiler.ir.ranges import range_of
from sjdsl.compiler.ir.types import (
    describe,
    hull,
    integer,
    interval,
    is_number,
    join_units,
    over_unit,
    real,
    rounded,
    times_unit,
    without_zero,
)

VERBS = {"+": "add", "-": "subtract", "*": "multiply", "/": "divide", "//": "divide", "%": "take the remainder of"}


def mismatch(scope: Scope, span: Span, verb: str, left: ir.Type, right: ir.Type, help: str = "") -> Poisoned:
    return scope.problems.fail(errors.UnitMismatch(span, verb=verb, left=describe(left), right=describe(right), help=help))


def arithmetic(e: ast.Binary, left: ir.Expr, right: ir.Expr, scope: Scope) -> ir.Expr:
    """Returns `left op right`; two constants become one."""
    a, b = left.type, right.type
    if a.by and b.by == a.by and e.op in ("+", "-") and a.kind in ("int", "real"):
        return _typed(e, left, right, join_units(a.unit, b.unit), scope)
    if not (is_number(a) and is_number(b)):
        raise mismatch(scope, e.span, VERBS[e.op], a, b)
    match e.op:
        case "*":
            unit = times_unit(a.unit, b.unit)
        case "/":
            if divisor_can_be_zero(right, scope):
                raise _zero_divisor(e.right.span, right, scope)
            if is_share(left, right):
                return ir.Arithmetic(type=real(0.0, 1.0, "fraction"), fn="/", args=(left, right), origin=e.span)
            unit = over_unit(a.unit, b.unit)
        case "%" | "//":
            if a.kind != "int" or b.kind != "int":
                written = "%" if e.op == "%" else "quotient"
                raise mismatch(scope, e.span, VERBS[e.op], a, b, f"`{written}` is for whole numbers")
            if divisor_can_be_zero(right, scope):
                raise _zero_divisor(e.right.span, right, scope)
            unit = join_units(a.unit, b.unit) if e.op == "%" else over_unit(a.unit, b.unit)
        case _:
            unit = join_units(a.unit, b.unit)
    return _typed(e, left, right, unit, scope)


def _zero_divisor(span: Span, divisor: ir.Expr, scope: Scope) -> Poisoned:
    """Reports a divisor that can be 0; what is no number of the game is guarded where it is used."""
    help_ = ""
    if isinstance(divisor, ir.Number):
        help_ = "divide by another number"
    elif not any(isinstance(n, ir.ParamRef) for n in ir.walk(divisor)):
        written = " ".join(scope.static.sources[span.file].text[span.start : span.end].split())
        help_ = f"guard it: `when {written} > 0 {{ … }}`"
    return scope.problems.fail(errors.ZeroDivisor(span, labels=parameters_read(scope.static, divisor), help=help_))


def _typed(e: ast.Binary, left: ir.Expr, right: ir.Expr, unit: ir.Unit | None, scope: Scope) -> ir.Expr:
    if unit is None:
        raise mismatch(scope, e.span, VERBS[e.op], left.type, right.type)
    divisor = without_zero(right.type) if e.op == "/" else right.type
    low, high = interval(e.op, left.type, divisor)
    kind = "int" if left.type.kind == right.type.kind == "int" and e.op != "/" else "real"
    if kind == "real" and unit in ("count", "steps", "cells"):
        unit = "number"
    if unit == "fraction" and (low < 0 or high > 1):
        unit = "number"
    type_ = ir.Type(kind=kind, unit=unit, low=low, high=high, by=left.type.by)  # type: ignore[arg-type]
    if isinstance(left, ir.Number) and isinstance(right, ir.Number):
        value = fold(e.op, left.value, right.value)
        return ir.Number(type=type_.model_copy(update={"low": value, "high": value}), value=value, origin=e.span)
    return ir.Arithmetic(type=type_, fn=e.op, args=(left, right), origin=e.span)  # type: ignore[arg-type]


def nearest_whole(e: ast.Call, value: ir.Expr, scope: Scope) -> ir.Expr:
    """Returns `round(value)`, which is a reward if that is one, else a bare number."""
    if not is_number(value.type):
        raise wrong_type(scope, e.arguments[0], "a number", value.type)
    if value.type.kind == "int":
        return value
    low, high = rounded(*narrowed(value, scope.facts_and_requires))
    if max(-low, high) > limits.MAX_VALUE:
        labels = parameters_read(scope.static, value)
        raise scope.problems.fail(errors.RoundsTooFar(e.span, labels=labels, name="`round`", limit=limits.MAX_VALUE))
    unit = "reward" if value.type.unit == "reward" else "number"
    type_ = integer(low, high, unit)  # type: ignore[arg-type]
    if isinstance(value, ir.Number):
        return ir.Number(type=type_, value=round(value.value), origin=e.span)
    return ir.Arithmetic(type=type_, fn="round", args=(value,), origin=e.span)


def divisor_can_be_zero(divisor: ir.Expr, scope: Scope) -> bool:
    """Returns whether neither its range (as a float32), a guard nor a `require` excludes 0."""
    computed = range_of(divisor)
    if computed.low > 0 or computed.high < 0:
        return False
    counted = divisor
    while isinstance(counted, ir.Named):
        counted = counted.value
    if isinstance(counted, ir.Count) and not can_be_empty(counted.domain, scope):
        return False
    known = scope.facts_and_requires
    return not (compares(divisor, ">", 0, known) or compares(divisor, ">=", 1, known) or compares(divisor, "!=", 0, known))


def is_share(left: ir.Expr, right: ir.Expr) -> bool:
    """Returns whether the quotient is `count(K where …) / count(G)` with K inside G: a fraction."""
    if not (isinstance(left, ir.Count) and isinstance(right, ir.Count)):
        return False
    part, whole = left.domain, right.domain
    if whole.where is not None or whole.restriction is not None or whole.on is not None or part.on is not None:
        return False
    return part.var.who == whole.var.who and set(part.var.kinds) <= set(whole.var.kinds)


def compare(e: ast.Binary, left: ir.Expr, right: ir.Expr, scope: Scope) -> ir.Expr:
    """Returns `left < right` and its like."""
    if not (is_number(left.type) and is_number(right.type)):
        named = {left.type.kind, right.type.kind} & {"word", "agent", "cell", "member"}
        help_ = "words, agents and cells are compared with `is` and `is not`" if named else ""
        raise mismatch(scope, e.span, "compare", left.type, right.type, help_)
    if join_units(left.type.unit, right.type.unit) is None:
        raise mismatch(scope, e.span, "compare", left.type, right.type)
    return ir.Compare(fn=e.op, left=left, right=right, origin=e.span)  # type: ignore[arg-type]


def extreme(e: ast.Call, args: list[ir.Expr], scope: Scope) -> ir.Expr:
    """Returns `min(...)` or `max(...)`."""
    type_ = join_types([a.type for a in args], scope, "compare", e)
    if not is_number(type_):
        raise scope.problems.fail(errors.WrongType(e.span, wanted="a number", given=describe(type_)))
    pick = min if e.name.text == "min" else max
    low, high = pick(a.type.low for a in args), pick(a.type.high for a in args)
    type_ = _regain_unit(type_.model_copy(update={"low": low, "high": high}), args)
    values = [a.value for a in args if isinstance(a, ir.Number)]
    if len(values) == len(args):
        return ir.Number(type=type_, value=pick(values), origin=e.span)
    return ir.Arithmetic(type=type_, fn=e.name.text, args=tuple(args), origin=e.span)  # type: ignore[arg-type]


def _regain_unit(type_: ir.Type, args: list[ir.Expr]) -> ir.Type:
    return type_.model_copy(update={"unit": next((a.type.unit for a in args if a.type.unit != "number"), "number")})


def join_types(types: list[ir.Type], scope: Scope, verb: str, tree: ast.Expr) -> ir.Type:
    """Returns the type that holds all the given ones: one unit, the hull of the intervals, the union of the words."""
    joined = types[0]
    for other in types[1:]:
        if joined.by != other.by:
            raise mismatch(scope, tree.span, verb, joined, other)
        if {joined.kind, other.kind} <= {"int", "real"}:
            unit = join_units(joined.unit, other.unit)
            if unit is None:
                raise mismatch(scope, tree.span, verb, joined, other)
            low, high = hull([joined, other])
            kind = "int" if joined.kind == other.kind == "int" else "real"
            joined = joined.model_copy(update={"kind": kind, "unit": unit, "low": low, "high": high})
        elif joined.kind == other.kind == "word":
            joined = joined.model_copy(update={"words": tuple(dict.fromkeys(joined.words + other.words))})
        elif joined.kind != other.kind:
            raise mismatch(scope, tree.span, verb, joined, other)
    return joined

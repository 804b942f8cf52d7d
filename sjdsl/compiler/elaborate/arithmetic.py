"""Elaborates arithmetic and comparison: constant folding, intervals, and units that match."""

from collections.abc import Sequence
from math import inf
from typing import Literal

from sjdsl.compiler import ast, ir
from sjdsl.compiler.diagnostics import errors, limits
from sjdsl.compiler.diagnostics.problems import Poisoned
from sjdsl.compiler.diagnostics.source import Span
from sjdsl.compiler.elaborate.declaration_labels import parameters_read
from sjdsl.compiler.elaborate.domains import can_be_empty
from sjdsl.compiler.elaborate.lookup import interval_text
from sjdsl.compiler.elaborate.scope import Scope, wrong_type
from sjdsl.compiler.ir.implications import compares, narrowed_real
from sjdsl.compiler.ir.operations import CALCULATIONS, Calculation, Domain
from sjdsl.compiler.ir.printer import expression_text as text
from sjdsl.compiler.ir.queries import contains
from sjdsl.compiler.ir.range_arithmetic import FLOAT32
from sjdsl.compiler.ir.ranges import apart, range_of
from sjdsl.compiler.ir.types import (
    INTEGER_UNITS,
    describe,
    hull,
    is_number,
    join_units,
    real,
    without_zero,
)


def mismatch(
    scope: Scope, span: Span, verb: str, left: ir.Type, right: ir.Type, help: str = ""
) -> Poisoned:
    """Reports two operands whose units don't mix."""
    return scope.fail(
        errors.UnitMismatch(span, verb=verb, left=describe(left), right=describe(right), help=help)
    )


def calculation(
    operation: Calculation, e: ast.Expr, trees: Sequence[ast.Expr], scope: Scope
) -> ir.Expr:
    """Returns an operation on numbers, or on rows of numbers; on constants, its result.

    operation: its entry in the table of operations. trees: its operands.
    """
    return calculated(operation, e, trees, scope.expressions(trees), scope)


def calculated(
    operation: Calculation,
    e: ast.Expr,
    trees: Sequence[ast.Expr],
    args: Sequence[ir.Expr],
    scope: Scope,
) -> ir.Expr:
    """Returns `calculation` of operands that are elaborated."""
    types = [arg.type for arg in args]
    if not (operation.rows and _are_rows_with_same_keys(types)):
        _check_numbers(operation, e, trees, types, scope)
    if operation.divisor is not None and divisor_can_be_zero(args[operation.divisor], scope):
        raise _zero_divisor(trees[operation.divisor].span, args[operation.divisor], scope)
    if operation.share and _is_share(args[0], args[1]):
        share = real(0.0, 1.0, "fraction")
        return ir.Arithmetic(type=share, fn=operation.name, args=tuple(args), origin=e.span)
    if operation.unchanged and types[0].kind == "int":
        return args[0]
    type_ = _result(operation, e, args, scope)
    if operation.apart is not None:
        first, second = operation.apart
        _check_apart(e, args[first], args[second], scope)
    numbers = [arg.value for arg in args if isinstance(arg, ir.Number)]
    if len(numbers) == len(args):
        value = operation.fold(*numbers)
        constant = type_.changed(low=value, high=value)
        return ir.Number(type=constant, value=value, origin=e.span)
    return ir.Arithmetic(type=type_, fn=operation.name, args=tuple(args), origin=e.span)


def power(e: ast.Binary, scope: Scope) -> ir.Expr:
    """Returns `a ^ b`: a product of b factors, or `exp(b * log(a))`.

    The former if b is known when the game is compiled, and whole.
    """
    base, exponent = scope.expressions((e.left, e.right))
    fixed = exponent
    while isinstance(fixed, ir.Named):
        fixed = fixed.value
    if isinstance(fixed, ir.Number) and fixed.type.kind == "int":
        if not 0 <= fixed.value <= limits.MAX_EXPONENT:
            raise _exponent_outside(e, int(fixed.value), scope)
        return calculated(CALCULATIONS["^"], e, [e.left, e.right], [base, fixed], scope)
    logarithm = calculated(CALCULATIONS["log"], e, [e.left], [base], scope)
    product = calculated(CALCULATIONS["*"], e, [e.right, e.left], [exponent, logarithm], scope)
    return calculated(CALCULATIONS["exp"], e, [e], [product], scope)


def _exponent_outside(e: ast.Binary, value: int, scope: Scope) -> Poisoned:
    written = scope.static.written(e.left.span)
    help_ = f"write `1 / {written} ^ {-value}`" if value < 0 else ""
    high = limits.MAX_EXPONENT
    return scope.fail(
        errors.OutOfLimits(
            e.right.span, name="the exponent", value=value, low=0, high=high, help=help_
        )
    )


def _are_rows_with_same_keys(types: Sequence[ir.Type]) -> bool:
    by = types[0].indexed_by
    return bool(by) and all(t.indexed_by == by and t.kind in ("int", "real") for t in types)


def _check_numbers(
    operation: Calculation,
    e: ast.Expr,
    trees: Sequence[ast.Expr],
    types: Sequence[ir.Type],
    scope: Scope,
) -> None:
    """Reports operands that are no numbers, or not the whole numbers that the operation takes."""
    for tree, type_ in zip(trees, types, strict=True):
        if is_number(type_):
            continue
        if operation.verb:
            raise mismatch(scope, e.span, operation.verb, types[0], types[1])
        raise wrong_type(scope, tree, "a number", type_)
    if operation.whole_only and any(t.kind != "int" for t in types):
        help_ = f"`{operation.name}` is for whole numbers"
        raise mismatch(scope, e.span, operation.verb, types[0], types[1], help_)


def _check_apart(e: ast.Expr, low: ir.Expr, high: ir.Expr, scope: Scope) -> None:
    """Reports two bounds of an operation that can be equal or cross, as float32 too."""
    known = scope.facts_and_requires
    compared = any(
        compares(low, sign, high, known) or compares(high, sign, low, known) for sign in (">", "!=")
    )
    if apart(low, high, compared):
        return
    problem = errors.RoundedToOne if compared else errors.Crossed
    labels = parameters_read(scope.static, low, high)
    raise scope.fail(problem(e.span, labels=labels, low=text(low), high=text(high)))


def _zero_divisor(span: Span, divisor: ir.Expr, scope: Scope) -> Poisoned:
    """Reports a divisor that can be 0; one without parameters can be guarded where it is used."""
    help_ = ""
    if isinstance(divisor, ir.Number):
        help_ = "divide by another number"
    elif not contains(divisor, ir.ParamRef):
        help_ = f"guard it: `when {scope.static.written(span)} > 0 {{ … }}`"
    labels = parameters_read(scope.static, divisor)
    return scope.fail(errors.ZeroDivisor(span, labels=labels, help=help_))


def _result(operation: Calculation, e: ast.Expr, args: Sequence[ir.Expr], scope: Scope) -> ir.Type:
    """Returns the type of what is calculated from numbers, or from rows of them."""
    types = [a.type for a in args]
    unit = operation.unit(*(t.unit for t in types))
    if unit is None:
        raise _unit_mismatch(operation, e, types, scope)
    ends = [(t.low, t.high) for t in types]
    if operation.divisor is not None:
        divisor = without_zero(types[operation.divisor])
        ends[operation.divisor] = divisor.low, divisor.high
    if operation.bounded or operation.finite or operation.domain is not None:
        ends = [narrowed_real(a, scope.facts_and_requires) for a in args]
    if operation.domain is not None:
        _check_domain(operation, operation.domain, e, args[0], scope)
    low, high = operation.interval(*ends)
    if operation.finite and max(-low, high) > FLOAT32:
        labels = parameters_read(scope.static, *args)
        raise scope.fail(errors.PowerTooLarge(e.span, labels=labels))
    if operation.bounded and max(-low, high) > limits.MAX_VALUE:
        labels = parameters_read(scope.static, *args)
        raise scope.fail(
            errors.RoundsTooFar(
                e.span, labels=labels, name=f"`{operation.name}`", limit=limits.MAX_VALUE
            )
        )
    is_whole = operation.kind == "whole" or (
        operation.kind == "joined" and all(t.kind == "int" for t in types)
    )
    is_no_fraction = unit == "fraction" and (low < 0 or high > 1)
    is_no_count = unit in INTEGER_UNITS and not is_whole
    if not operation.keeps_unit and (is_no_fraction or is_no_count):
        unit = "number"
    kind: Literal["int", "real"] = "int" if is_whole else "real"
    return ir.Type(kind=kind, unit=unit, low=low, high=high, indexed_by=types[0].indexed_by)


def _check_domain(
    operation: Calculation, domain: Domain, e: ast.Expr, arg: ir.Expr, scope: Scope
) -> None:
    """Reports an argument that may be none of the numbers that a function takes."""
    known = scope.facts_and_requires
    low, high = narrowed_real(arg, known, loose=False)
    if domain.low <= low and high <= domain.high:
        return
    from_zero = domain.high == inf
    is_guarded = compares(arg, ">", 0, known) or (
        not domain.above and compares(arg, ">=", 0, known)
    )
    if from_zero and is_guarded:
        return
    labels = parameters_read(scope.static, arg)
    is_power = isinstance(e, ast.Binary)
    if is_power and not from_zero:
        raise scope.fail(errors.PowerTooLarge(e.span, labels=labels))
    span = arg.origin or e.span
    written = scope.static.written(span)
    help_ = f"write `{domain.instead.format(written)}` in its place"
    if from_zero:
        sign = ">" if domain.above else ">="
        help_ = f"guard it, `when {written} {sign} 0 {{ … }}`, or {help_}"
    taken = domain.named
    if is_power:
        taken = (
            "a base above 0, as its exponent isn't a whole number known when the game is compiled"
        )
    raise scope.fail(
        errors.OutsideDomain(
            span,
            labels=labels,
            help=help_,
            name="^" if is_power else operation.name,
            taken=taken,
            reached=interval_text(low, high),
        )
    )


def _unit_mismatch(
    operation: Calculation, e: ast.Expr, types: Sequence[ir.Type], scope: Scope
) -> Poisoned:
    """Reports the first operand whose unit doesn't mix with the unit of those before it."""
    joined, *others, last = types
    for type_ in others:
        unit = join_units(joined.unit, type_.unit)
        if unit is None:
            last = type_
            break
        joined = joined.changed(unit=unit)
    return mismatch(scope, e.span, operation.verb or "compare", joined, last)


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
    return not (
        compares(divisor, ">", 0, known)
        or compares(divisor, ">=", 1, known)
        or compares(divisor, "!=", 0, known)
    )


def _is_share(left: ir.Expr, right: ir.Expr) -> bool:
    """Returns whether the quotient is `count(K where …) / count(G)` with K inside G: a fraction."""
    if not (isinstance(left, ir.Count) and isinstance(right, ir.Count)):
        return False
    part = left.domain
    whole = right.domain
    is_whole = whole.where is None and whole.restriction is None and whole.on is None
    if not is_whole or part.on is not None:
        return False
    entity_type = part.var.entity_type
    return entity_type.what == whole.var.entity_type.what and set(entity_type.names) <= set(
        whole.var.entity_type.names
    )


def compare(e: ast.Binary, scope: Scope) -> ir.Expr:
    """Returns `left < right` and its like."""
    left, right = scope.expressions((e.left, e.right))
    if not (is_number(left.type) and is_number(right.type)):
        named = {left.type.kind, right.type.kind} & {"word", "agent", "cell", "member"}
        help_ = "words, agents and cells are compared with `is` and `is not`" if named else ""
        raise mismatch(scope, e.span, "compare", left.type, right.type, help_)
    if join_units(left.type.unit, right.type.unit) is None:
        raise mismatch(scope, e.span, "compare", left.type, right.type)
    return ir.Compare(fn=e.op, left=left, right=right, origin=e.span)  # type: ignore[arg-type]


def join_types(types: list[ir.Type], scope: Scope, verb: str, tree: ast.Expr) -> ir.Type:
    """Returns one type for values of several: their unit, hull of intervals, union of words."""
    joined = types[0]
    for other in types[1:]:
        if joined.indexed_by != other.indexed_by:
            raise mismatch(scope, tree.span, verb, joined, other)
        if {joined.kind, other.kind} <= {"int", "real"}:
            unit = join_units(joined.unit, other.unit)
            if unit is None:
                raise mismatch(scope, tree.span, verb, joined, other)
            low, high = hull([joined, other])
            kind = "int" if joined.kind == other.kind == "int" else "real"
            joined = joined.changed(kind=kind, unit=unit, low=low, high=high)
        elif joined.kind == other.kind == "word":
            union = tuple(dict.fromkeys(joined.words + other.words))
            joined = joined.changed(words=union)
        elif joined.kind != other.kind:
            raise mismatch(scope, tree.span, verb, joined, other)
    return joined

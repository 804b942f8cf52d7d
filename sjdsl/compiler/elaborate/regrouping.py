"""Suggests another order of factors where units don't mix: `a * (b / c)` for `a * b / c`."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

from sjdsl.compiler import ast
from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.diagnostic import Diagnostic
from sjdsl.compiler.diagnostics.problems import Poisoned, Problems
from sjdsl.compiler.elaborate.scope import Scope


def add_regrouped(e: ast.Binary, scope: Scope) -> None:
    """Adds to the message about units inside a product how to write it, if dividing first helps."""
    diagnostics = scope.problems.diagnostics
    for place, diagnostic in enumerate(diagnostics):
        if _is_helpless_mismatch(diagnostic, e):
            suggested = next((tree for tree in _regrouped(e) if _has_units(tree, scope)), None)
            if suggested is not None:
                help_ = f"divide first: `{_written(suggested, scope)}`"
                diagnostics[place] = replace(diagnostic, help=help_)
            return


def _regrouped(e: ast.Binary) -> Iterator[ast.Binary]:
    """Yields `b * (a / c)` for each factor a and divisor c of a product: a quotient is first."""
    factors, divisors = _parts(e)
    for divisor in divisors:
        for factor in factors[::-1]:
            other_factors = [other for other in factors if other is not factor]
            other_divisors = [other for other in divisors if other is not divisor]
            if other_factors:
                quotient = ast.Binary(e.span, "/", factor, divisor)
                yield _chain([*other_factors, quotient], other_divisors)


def _parts(e: ast.Expr) -> tuple[list[ast.Expr], list[ast.Expr]]:
    """Returns the factors and the divisors of a product."""
    if not isinstance(e, ast.Binary) or e.op not in ("*", "/"):
        return [e], []
    factors, divisors = _parts(e.left)
    if e.op == "*":
        factors.append(e.right)
    else:
        divisors.append(e.right)
    return factors, divisors


def _chain(factors: Sequence[ast.Expr], divisors: Sequence[ast.Expr]) -> ast.Binary:
    """Returns the factors multiplied in order, then divided by the divisors in order."""
    product, *others = factors
    for factor in others:
        product = ast.Binary(product.span, "*", product, factor)
    for divisor in divisors:
        product = ast.Binary(product.span, "/", product, divisor)
    assert isinstance(product, ast.Binary)
    return product


def _has_units(e: ast.Binary, scope: Scope) -> bool:
    """Returns whether no units clash in an expression, whatever else may be wrong with it."""
    quiet = Problems()
    try:
        scope.but(problems=quiet).expression(e)
    except Poisoned:
        return not any(isinstance(d, errors.UnitMismatch) for d in quiet.diagnostics)
    return True


def _is_helpless_mismatch(diagnostic: Diagnostic, e: ast.Binary) -> bool:
    """Returns whether a diagnostic is about units inside a product, and has no help yet."""
    inner = diagnostic.span
    outer = e.span
    is_inside = outer.start <= inner.start and inner.end <= outer.end and outer.file == inner.file
    return isinstance(diagnostic, errors.UnitMismatch) and is_inside and not diagnostic.help


def _written(e: ast.Expr, scope: Scope) -> str:
    """Returns a product as its author would write it, with the quotient in brackets."""
    if isinstance(e, ast.Binary) and e.op in ("*", "/"):
        right = _written(e.right, scope)
        if isinstance(e.right, ast.Binary | ast.Unary):
            right = f"({right})"
        return f"{_written(e.left, scope)} {e.op} {right}"
    text = scope.static.written(e.span)
    return f"({text})" if isinstance(e, ast.Binary) else text

"""Suggests another order of the factors of a product whose units don't go together: `a * (b / c)` for `a * b / c`."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import reduce

from sjdsl.compiler import ast
from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.problems import Poisoned, Problems
from sjdsl.compiler.elaborate.scope import Scope


def add_regrouped(e: ast.Binary, scope: Scope) -> None:
    """Adds to the message about units inside a product how to write the product, if a quotient taken first helps."""
    found = scope.problems.found
    at = next(
        (
            i
            for i, d in enumerate(found)
            if isinstance(d, errors.UnitMismatch) and _is_inside(d, e) and not d.help
        ),
        None,
    )
    if at is None:
        return
    suggested = next((tree for tree in _regrouped(e) if _has_units(tree, scope)), None)
    if suggested is not None:
        found[at] = replace(found[at], help=f"divide first: `{_written(suggested, scope)}`")


def _is_inside(mismatch: errors.UnitMismatch, e: ast.Binary) -> bool:
    return (
        mismatch.span.file == e.span.file
        and e.span.start <= mismatch.span.start
        and mismatch.span.end <= e.span.end
    )


def _regrouped(e: ast.Binary) -> Iterator[ast.Binary]:
    """Yields the product with one of its quotients taken first, for each pair of a factor and a divisor."""
    factors, divisors = _parts(e)
    for divisor in divisors:
        for factor in factors[::-1]:
            others = [f for f in factors if f is not factor]
            if others:
                quotient = ast.Binary(e.span, "/", factor, divisor)
                left = [d for d in divisors if d is not divisor]
                yield _chain([*others, quotient], left)


def _parts(e: ast.Expr) -> tuple[list[ast.Expr], list[ast.Expr]]:
    """Returns the factors and the divisors of a product."""
    if not isinstance(e, ast.Binary) or e.op not in ("*", "/"):
        return [e], []
    factors, divisors = _parts(e.left)
    (factors if e.op == "*" else divisors).append(e.right)
    return factors, divisors


def _chain(factors: Sequence[ast.Expr], divisors: Sequence[ast.Expr]) -> ast.Binary:
    product = reduce(lambda left, right: ast.Binary(left.span, "*", left, right), factors)
    chain = reduce(lambda left, right: ast.Binary(left.span, "/", left, right), divisors, product)
    assert isinstance(chain, ast.Binary)
    return chain


def _has_units(e: ast.Binary, scope: Scope) -> bool:
    """Returns whether the units of an expression go together, whatever else may be wrong with it."""
    quiet = Problems()
    try:
        scope.but(problems=quiet).expression(e)
    except Poisoned:
        return not any(isinstance(d, errors.UnitMismatch) for d in quiet.found)
    return True


def _written(e: ast.Expr, scope: Scope) -> str:
    """Returns a product as its author would write it: the parts as they are, the quotient in brackets."""
    if isinstance(e, ast.Binary) and e.op in ("*", "/"):
        right = _written(e.right, scope)
        return f"{_written(e.left, scope)} {e.op} " + (
            f"({right})" if isinstance(e.right, ast.Binary | ast.Unary) else right
        )
    text = scope.static.sources[e.span.file].text[e.span.start : e.span.end]
    words = " ".join(text.split())
    return f"({words})" if isinstance(e, ast.Binary) else words

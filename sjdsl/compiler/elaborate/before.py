"""Elaborates `before(e)` of checks: the value of e when the step began."""

from dataclasses import replace

from sjdsl.compiler import ast, ir
from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.elaborate.scope import Scope, wrong_type
from sjdsl.compiler.ir.operations import Function

WHERE = "`before` stands in `always` and `once` of `checks`, not inside another; a rule keeps what it needs later in a field"


def before(_: Function, e: ast.Call, scope: Scope) -> ir.Expr:
    """Returns `before(e)`; what is known of the state now, and who has a place now, says nothing of that state."""
    if not scope.about_steps:
        wrong = errors.WrongType(e.span, wanted="a value of one state", given="`before`, which is about a step", help=WHERE)
        raise scope.problems.fail(wrong)
    (value,) = e.arguments
    bodies = (
        {v.name for v in scope.variables.values() if isinstance(v, ir.Member) and v.sort.what != "cell"} if scope.static.can_be_away else ()
    )
    inner = replace(scope, about_steps=False, facts=(), elsewhere=frozenset(bodies)).expression(value)
    if inner.type.kind in ("member", "mix"):
        raise wrong_type(scope, value, "a value", inner.type)
    return ir.Before(type=inner.type, value=inner, origin=e.span)

"""Elaborates `min(e over D otherwise v)` and `max`: what stands for a domain without members, and which domains always have one."""

from sjdsl.compiler import ast, ir
from sjdsl.compiler.diagnostics import errors, guesses
from sjdsl.compiler.elaborate.arithmetic import join_types
from sjdsl.compiler.elaborate.domains import can_be_empty, domain
from sjdsl.compiler.elaborate.scope import Scope, wrong_type
from sjdsl.compiler.ir.operations import REDUCTIONS
from sjdsl.compiler.ir.types import is_number


def extreme(e: ast.Extreme, scope: Scope) -> ir.Expr:
    """Returns the least or greatest value over a domain."""
    reduction = REDUCTIONS.get(e.name.text)
    if reduction is None or reduction.adds:  # a sum is `ast.Total`
        raise scope.problems.unknown(e.name, REDUCTIONS, "what there is over a domain", guesses.FUNCTIONS | guesses.OVER_DOMAINS)
    built, inner = domain(e.domain, scope)
    value = inner.expression(e.value)
    otherwise = None if e.if_none is None else scope.expression(e.if_none)
    for tree, part in ((e.value, value), (e.if_none, otherwise)):
        if tree is not None and part is not None and not is_number(part.type):
            raise wrong_type(scope, tree, "a number", part.type)
    if otherwise is None and can_be_empty(built, scope):
        raise scope.problems.fail(errors.ExtremeOfNothing(e.span, name=e.name.text, domain=written(e.domain, scope)))
    types = [value.type] if otherwise is None else [value.type, otherwise.type]
    type_ = join_types(types, scope, "compare", e)
    return ir.Extreme(type=type_, fn=e.name.text, value=value, domain=built, otherwise=otherwise, origin=e.span)  # type: ignore[arg-type]


def written(d: ast.Domain, scope: Scope) -> str:
    """Returns a domain as its author wrote it."""
    return " ".join(scope.static.sources[d.span.file].text[d.span.start : d.span.end].split())

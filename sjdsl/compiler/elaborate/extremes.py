"""Elaborates `min(e over D otherwise v)` and `max`: what stands for a domain without members, and which domains always have one."""

from sjdsl.compiler import ast, ir
from sjdsl.compiler.diagnostics import errors, guesses
from sjdsl.compiler.elaborate.arithmetic import join_types
from sjdsl.compiler.elaborate.domains import domain, most_members
from sjdsl.compiler.elaborate.scope import Scope, wrong_type
from sjdsl.compiler.ir.implications import compares, narrowed
from sjdsl.compiler.ir.types import integer, is_number

OVER_DOMAINS = ("sum", "min", "max")


def extreme(e: ast.Extreme, scope: Scope) -> ir.Expr:
    """Returns the least or greatest value over a domain."""
    if e.name.text not in ("min", "max"):
        raise scope.problems.unknown(e.name, OVER_DOMAINS, "what there is over a domain", guesses.FUNCTIONS | guesses.OVER_DOMAINS)
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


def can_be_empty(d: ir.Domain, scope: Scope) -> bool:
    """Returns whether neither the map, the rules nor a guard such as `count(D) > 0` gives a domain a member."""
    static, known = scope.static, scope.facts_and_requires
    members = ir.Count(type=integer(0, most_members(d, scope)), domain=d)
    if narrowed(members, known)[0] > 0 or compares(members, "!=", 0, known):
        return False
    if d.where is not None or d.on is not None:
        return True
    match d.restriction:
        case None if d.var.who == "cell":
            return not any(static.cells.get(kind, 0) for kind in d.var.kinds)
        case None:
            return static.can_be_away and not _somebody_is_here(d.var, scope)
        case ir.Among():
            return d.var.who == "cell"
        case _:
            return True


def _somebody_is_here(var: ir.Member, scope: Scope) -> bool:
    """Returns whether a domain around has an agent (or such a mover); other parts of a game may speak of one that is away."""
    agents = (v for v in scope.variables.values() if isinstance(v, ir.Member) and (v.who, v.kinds) == (var.who, var.kinds))
    return scope.part in ("phase", "start", "metrics", "checks", "policy") and any(agents)


def written(d: ast.Domain, scope: Scope) -> str:
    """Returns a domain as its author wrote it."""
    return " ".join(scope.static.sources[d.span.file].text[d.span.start : d.span.end].split())

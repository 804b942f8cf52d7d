"""Free variables of an expression, which it reads but does not bind, and their substitution."""

from collections.abc import Iterator
from typing import Any, TypeVar

from sjdsl.compiler import ir
from sjdsl.compiler.diagnostics.tree import rewrite

N = TypeVar("N", bound=ir.Node)
Variable = ir.Member | ir.Local


def free_variables(e: ir.Node) -> list[Variable]:
    """Returns the free variables, each once, in order of appearance."""
    variables: dict[str, Variable] = {}
    for variable in _free(e, frozenset()):
        variables.setdefault(variable.name, variable)
    return list(variables.values())


def variables_around(domain: ir.Domain) -> list[Variable]:
    """Returns the variables of statements around that the `where` of a domain of cells reads."""
    if domain.where is None:
        return []
    return [v for v in free_variables(domain.where) if v.name != domain.var.name]


def _free(node: ir.Node, bound: frozenset[str]) -> Iterator[Variable]:
    """Yields the free variables in a node. `bound`: the names bound around it."""
    if isinstance(node, Variable):
        if node.name not in bound:
            yield node
    elif isinstance(node, ir.Aggregate):
        domain = node.domain
        inner = bound | {domain.var.name}
        if domain.on is not None:
            inner |= {domain.on.name}
        for part, names in (
            (domain.restriction, bound),
            (domain.where, inner),
            (getattr(node, "value", None), inner),
            (getattr(node, "otherwise", None), bound),
        ):
            if part is not None:
                yield from _free(part, names)
    else:
        for child in ir.children(node):
            yield from _free(child, bound)


def renamed(node: N, names: dict[str, str]) -> N:
    """Returns a part of the rules with variables called differently."""

    def rename(inner: Any) -> Any:
        if isinstance(inner, Variable) and inner.name in names:
            return inner.changed(name=names[inner.name])
        return inner

    return rewrite(node, rename)

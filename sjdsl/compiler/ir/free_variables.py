"""Free variables of an expression, which it reads but does not bind, and their substitution."""

from collections.abc import Iterator
from typing import Any, TypeVar

from sjdsl.compiler import ir
from sjdsl.compiler.diagnostics.tree import rewrite

N = TypeVar("N", bound=ir.Node)
Variable = ir.Member | ir.Local


def free_variables(e: ir.Node) -> list[Variable]:
    """Returns the free variables, each once, in order of appearance."""
    found: dict[str, Variable] = {}
    for node in _free(e, frozenset()):
        found.setdefault(node.name, node)
    return list(found.values())


def variables_around(domain: ir.Domain) -> list[Variable]:
    """Returns the variables of the statements around that a domain of cells names in its `where`."""
    return (
        []
        if domain.where is None
        else [v for v in free_variables(domain.where) if v.name != domain.var.name]
    )


def _free(node: ir.Node, bound: frozenset[str]) -> Iterator[Variable]:
    if isinstance(node, ir.Aggregate):
        domain, value, otherwise = (
            node.domain,
            getattr(node, "value", None),
            getattr(node, "otherwise", None),
        )
        inner = bound | {m.name for m in (domain.var, domain.on) if m is not None}
        for part, around in (
            (domain.restriction, bound),
            (domain.where, inner),
            (value, inner),
            (otherwise, bound),
        ):
            if part is not None:
                yield from _free(part, around)
    elif isinstance(node, Variable):
        if node.name not in bound:
            yield node
    else:
        for child in ir.children(node):
            yield from _free(child, bound)


def renamed(node: N, names: dict[str, str]) -> N:
    """Returns a part of the rules with variables called differently."""

    def rename(inner: Any) -> Any:
        return (
            inner.model_copy(update={"name": names[inner.name]})
            if isinstance(inner, Variable) and inner.name in names
            else inner
        )

    return rewrite(node, rename)

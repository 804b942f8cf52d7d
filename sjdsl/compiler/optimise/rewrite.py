"""Rewrites the IR bottom-up; every pass is built on it."""

from collections.abc import Callable
from typing import Any, TypeVar

from sjdsl.compiler import ir

N = TypeVar("N", bound=ir.Node)
Rule = Callable[[Any], Any]


def rewrite(node: N, rule: Rule) -> N:
    """Returns `node` with `rule` applied to every node below it, inner ones first, then to itself.

    A rule returns a node, or for a sentence a tuple of sentences to stand in its place.
    """
    update: dict[str, Any] = {}
    for name in ir.inner_fields(type(node)):
        value = getattr(node, name)
        new = _rewritten(value, rule)
        if new is not value:
            update[name] = new
    changed = node.model_copy(update=update) if update else node
    return rule(changed)


def _rewritten(value: Any, rule: Rule) -> Any:
    if isinstance(value, ir.Node):
        return rewrite(value, rule)
    if isinstance(value, tuple) and any(isinstance(v, ir.Node) for v in value):
        items: list[Any] = []
        for item in value:
            new = rewrite(item, rule) if isinstance(item, ir.Node) else item
            items.extend(new if isinstance(new, tuple) else (new,))
        if len(items) == len(value) and all(a is b for a, b in zip(items, value, strict=True)):
            return value
        return tuple(items)
    return value

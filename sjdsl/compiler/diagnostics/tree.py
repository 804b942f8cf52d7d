"""Trees of nodes, for the syntax, the typed IR and array programs: children, walks, replacement."""

from collections.abc import Callable, Iterator
from copy import copy
from functools import cache
from typing import Any, Generic, TypeVar

N = TypeVar("N")
T = TypeVar("T")


class TreeNode(Generic[N]):
    """A part of a tree of nodes N: the nodes directly inside it are in its fields, or in tuples."""


def children(node: TreeNode[N]) -> list[N]:
    """Returns the nodes directly inside `node`, in field order."""
    nodes: list[N] = []
    for value in vars(node).values():
        _gather(value, nodes)
    return nodes


def walk(node: TreeNode[N]) -> Iterator[N]:
    """Yields `node` and every node below it, outermost first."""
    waiting: list[Any] = [node]
    while waiting:
        following = waiting.pop()
        yield following
        waiting += reversed(children(following))


def _gather(value: Any, nodes: list[Any]) -> None:
    """Adds a field's value to `nodes` if it is a node, or those in it if it is a tuple."""
    kind = value.__class__
    if kind is tuple:
        for item in value:
            _gather(item, nodes)
    elif _is_node(kind):
        nodes.append(value)


@cache
def _is_node(kind: type) -> bool:
    """Returns whether values of a type are nodes; pydantic's `isinstance` is 100 times as slow."""
    return issubclass(kind, TreeNode)


def rewrite(node: T, rule: Callable[[Any], Any]) -> T:
    """Returns `node` with `rule` applied to every node below it, inner ones first, then to itself.

    A rule returns a node, or for a statement a tuple of statements to stand in its place.
    """
    update = {}
    for name, value in vars(node).items():
        new = _rewritten(value, rule)
        if new is not value:
            update[name] = new
    if update:
        node = copy(node)
        vars(node).update(update)
    result: T = rule(node)
    return result


def _rewritten(value: Any, rule: Callable[[Any], Any]) -> Any:
    """Returns a field's value with `rule` applied to the nodes in it; itself if none changed."""
    if _is_node(value.__class__):
        return rewrite(value, rule)
    if value.__class__ is not tuple:
        return value
    items: list[Any] = []
    for item in value:
        new = _rewritten(item, rule)
        if isinstance(new, tuple) and _is_node(item.__class__):
            items += new
        else:
            items.append(new)
    is_same = len(items) == len(value) and all(a is b for a, b in zip(items, value, strict=True))
    return value if is_same else tuple(items)

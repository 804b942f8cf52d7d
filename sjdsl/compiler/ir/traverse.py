"""Tree walking and rewriting of the typed IR: children of a node, all nodes below it, and bottom-up replacement."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cache
from typing import Annotated, Any, Literal, TypeVar, get_args, get_origin

from sjdsl.compiler.diagnostics.source import Span
from sjdsl.compiler.ir.node import Node, Type
from sjdsl.compiler.ir.sorts import Entry, Level, Sort

N = TypeVar("N", bound=Node)


def children(node: Node) -> list[Node]:
    """Returns the nodes directly inside `node`, in field order."""
    found: list[Node] = []
    for name in inner_fields(type(node)):
        value = getattr(node, name)
        if value is not None:
            _gather(value, found)
    return found


def walk(node: Node) -> Iterator[Node]:
    """Yields `node` and every node below it, outermost first."""
    waiting = [node]
    while waiting:
        following = waiting.pop()
        yield following
        waiting += reversed(children(following))


def _gather(value: Any, found: list[Node]) -> None:
    if isinstance(value, tuple):
        for item in value:
            _gather(item, found)
    elif _is_node(value.__class__):
        found.append(value)


@cache
def _is_node(kind: type) -> bool:
    """Whether values of a type are nodes; kept, for pydantic's own `isinstance` takes a hundred times as long."""
    return issubclass(kind, Node)


@cache
def inner_fields(kind: type[Node]) -> tuple[str, ...]:
    """Returns the fields that can hold nodes: most hold names and numbers, and a game is walked often."""
    return tuple(name for name, field in kind.model_fields.items() if _can_hold_nodes(field.annotation))


def _can_hold_nodes(annotation: object) -> bool:
    if get_origin(annotation) is Literal:
        return False
    if get_origin(annotation) is Annotated:
        return _can_hold_nodes(get_args(annotation)[0])
    inside = [a for a in get_args(annotation) if a is not Ellipsis]
    return (
        any(_can_hold_nodes(a) for a in inside)
        if inside
        else annotation not in (str, int, float, bool, type(None), Span, Type, Sort, Level, Entry)
    )


def rewrite(node: N, rule: Callable[[Any], Any]) -> N:
    """Returns `node` with `rule` applied to every node below it, inner ones first, then to itself.

    A rule returns a node, or for a statement a tuple of statements to stand in its place.
    """
    update: dict[str, Any] = {}
    for name in inner_fields(type(node)):
        value = getattr(node, name)
        new = _rewritten(value, rule)
        if new is not value:
            update[name] = new
    changed = node.model_copy(update=update) if update else node
    result: N = rule(changed)
    return result


def _rewritten(value: Any, rule: Callable[[Any], Any]) -> Any:
    if _is_node(value.__class__):
        return rewrite(value, rule)
    if isinstance(value, tuple) and any(_is_node(v.__class__) for v in value):
        items: list[Any] = []
        for item in value:
            new = rewrite(item, rule) if _is_node(item.__class__) else item
            items.extend(new if isinstance(new, tuple) else (new,))
        if len(items) == len(value) and all(a is b for a, b in zip(items, value, strict=True)):
            return value
        return tuple(items)
    return value

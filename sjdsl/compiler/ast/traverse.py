"""Tree walking of the AST: the nodes in a node, and all below it."""

from collections.abc import Iterator

from sjdsl.compiler.ast.node import Node


def walk(node: Node) -> Iterator[Node]:
    """Yields `node` and every node below it, outermost first."""
    waiting: list[object] = [node]
    while waiting:
        following = waiting.pop()
        if isinstance(following, tuple):
            waiting += reversed(following)
        elif isinstance(following, Node):
            yield following
            waiting += reversed(list(vars(following).values()))


def children(node: Node) -> Iterator[Node]:
    """Yields the nodes that a node is made of, in the order of its fields."""
    waiting = list(reversed(list(vars(node).values())))
    while waiting:
        following = waiting.pop()
        if isinstance(following, tuple):
            waiting += reversed(following)
        elif isinstance(following, Node):
            yield following

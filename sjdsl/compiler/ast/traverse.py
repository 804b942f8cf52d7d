"""Tree walking of the AST: all nodes below a node."""

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

"""The base class of AST nodes: frozen dataclasses, equal by content."""

from sjdsl.compiler.diagnostics.frozen import Record


class Node(Record):
    """One part of a text; its first field is its `span`."""

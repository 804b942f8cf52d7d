"""The base class of AST nodes: frozen dataclasses, equal by content."""

from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.diagnostics.source import Span
from sjdsl.compiler.diagnostics.tree import TreeNode


class Node(Record, TreeNode["Node"]):
    """One part of a text, at its `span`."""

    span: Span

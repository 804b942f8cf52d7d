"""Versions of the language: those this compiler reads, and the one that a file needs.

The first line says the oldest language in which the file can be read. A later version reads every file of an earlier one, and gives it
the same meaning: docs/versions.md is the policy.
"""

from collections.abc import Iterator

from sjdsl.compiler import ast
from sjdsl.compiler.ast.node import Node
from sjdsl.compiler.ast.traverse import walk
from sjdsl.compiler.diagnostics.source import Span

VERSIONS = ("1", "1.1")  # oldest first
OLDEST, NEWEST = VERSIONS[0], VERSIONS[-1]


def needed(file: ast.File) -> tuple[str, str, Span]:
    """Returns the oldest version that has all that a file uses, what it needs that version for, and where that stands first."""
    for span, what in _since_1_1(file):
        return "1.1", what, span
    return OLDEST, "", file.span


def _since_1_1(file: ast.File) -> Iterator[tuple[Span, str]]:
    for node in walk(file):
        what = _new_in_1_1(node)
        if what:
            span: Span = vars(node)["span"]  # that every node has as its first field
            yield span, what


def _new_in_1_1(node: Node) -> str:
    """Returns what a node is, in the manual's words, if it came with `sj 1.1`; a table of those that can be told by their syntax."""
    match node:
        case ast.Movers():
            return "movers"
        case ast.Shift() | ast.Send(domain=ast.Path()):
            return "agents and movers sent by a direction, or to a cell that a field holds"
        case ast.Move(course=course) if course is not None:
            return "`move` with a course"
        case ast.Map(edges="joined"):
            return "`map wraps`"
        case ast.Set(lot=ast.Name()):
            return "`by lot`"
        case ast.Argument() | ast.Chosen(arguments=tuple()):
            return "actions with arguments"
        case ast.CellType():
            return "fields that hold a cell"
        case ast.Constant(by=by) if by is not None:
            return "parameters by word, number or agent"
        case ast.Field(by=ast.Numbers() | ast.Name()):
            return "rows by number or by agent"
        case ast.Agents(attributes=attributes) if any(isinstance(attribute, ast.Blocks) for attribute in attributes):
            return "agents that block"
        case ast.Window(condition=condition) | ast.Show(condition=condition) if condition is not None:
            return "`window` and `show` with `when`"
        case ast.Entry(key=ast.Name(text=key)) if not key.isidentifier() or key == "otherwise":
            return "tables by number"
        case _:
            return ""

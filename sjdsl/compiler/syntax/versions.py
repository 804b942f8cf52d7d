"""Versions of the language: those this compiler reads, and the one that a file needs.

The first line says the oldest language in which the file can be read. A later version reads every file of an earlier one, and gives it
the same meaning: docs/versions.md is the policy.
"""

from collections.abc import Callable, Set

from sjdsl.compiler import ast
from sjdsl.compiler.ast.node import Node
from sjdsl.compiler.ast.traverse import walk
from sjdsl.compiler.diagnostics.source import Span

VERSIONS = ("1", "1.1", "1.2")  # oldest first
OLDEST, NEWEST = VERSIONS[0], VERSIONS[-1]


def needed(file: ast.File) -> tuple[str, str, Span]:
    """Returns the oldest version that has all that a file uses, what it needs that version for, and where that stands first."""
    nodes = list(walk(file))
    defines = {node.name.text for node in nodes if isinstance(node, ast.Define)}
    for version, find in NEW:
        for node in nodes:
            what = find(node, defines)
            if what:
                return version, what, vars(node)["span"]  # which every node has as its first field
    return OLDEST, "", file.span


def _new_in_1_2(node: Node, defines: Set[str]) -> str:
    """Returns what a node is, in the manual's words, if it came with `sj 1.2`. `defines`: the names of the file's own."""
    match node:
        case ast.Quantified():
            return "`any` and `all`"
        case ast.Call(name=ast.Name(text="quotient" | "round" | "before" as name)) if name not in defines:
            return f"`{name}`"
        case ast.Draw(source=ast.Table(entries=entries)) if any(entry.key.text.isdigit() for entry in entries):
            return "`draw` of numbers with weights"
        case ast.Constant(unit=ast.Name(text="number")):
            return "the unit `number`"
        case ast.Show(what=ast.Path(name=ast.Name(text=name), steps=())) if name == "step" or name in defines:
            return "`show` of `step` and of defines"
        case _:
            return ""


def _new_in_1_1(node: Node, _: Set[str]) -> str:
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


NEW: tuple[tuple[str, Callable[[Node, Set[str]], str]], ...] = (("1.2", _new_in_1_2), ("1.1", _new_in_1_1))  # newest first

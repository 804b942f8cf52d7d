"""The outline of a text: its symbols as a tree."""

from collections.abc import Iterable
from typing import Any

from lsprotocol import types

from sjdsl.compiler import ast
from sjdsl.compiler.diagnostics.source import Span
from sjdsl.editor.analysis import Analysis
from sjdsl.editor.positions import Lines

Kind = types.SymbolKind
SORTS: dict[type[object], tuple[types.SymbolKind, str]] = {  # the word is what a declaration without a name is called
    ast.Game: (Kind.Module, "game"), ast.Constant: (Kind.Number, "param"), ast.Kind: (Kind.Class, "kind"),
    ast.Group: (Kind.Interface, "group"), ast.Movers: (Kind.Class, "movers"), ast.Agents: (Kind.Class, "agents"),
    ast.Field: (Kind.Field, "field"), ast.Timer: (Kind.Field, "timer"), ast.Action: (Kind.EnumMember, "action"),
    ast.Shape: (Kind.Struct, "shape"), ast.Define: (Kind.Function, "define"), ast.Phase: (Kind.Method, "phase"),
    ast.Map: (Kind.Array, "map"), ast.Schedule: (Kind.Array, "schedule"), ast.Observe: (Kind.Object, "observe"),
    ast.Metrics: (Kind.Object, "metrics"), ast.Event: (Kind.Event, "event"), ast.Measure: (Kind.Variable, "metric"),
    ast.Checks: (Kind.Object, "checks"), ast.ScriptedPolicy: (Kind.Function, "policy"), ast.Scenario: (Kind.Object, "scenario"),
    ast.Variant: (Kind.Namespace, "variant"), ast.About: (Kind.String, "about"),
}  # fmt: skip
INSIDE = (
    "sections",
    "attributes",
    "metrics",
    "changes",
)  # what nodes call the declarations in them


def document_symbols(analysis: Analysis | None, lines: Lines) -> list[types.DocumentSymbol]:
    """Returns the declarations of a text, those inside others below them. `lines`: of the text that is shown, which may be newer."""
    return (
        [] if analysis is None or analysis.file is None else _symbols([analysis.file.game], lines)
    )


def _symbols(nodes: Iterable[Any], lines: Lines) -> list[types.DocumentSymbol]:
    """Returns the symbols of those nodes that are declarations."""
    found: list[types.DocumentSymbol] = []
    for node in nodes:
        if isinstance(node, ast.Acts):
            found += _symbols(node.actions, lines)
        elif type(node) in SORTS:
            kind, sort = SORTS[type(node)]
            if isinstance(node, ast.Constant) and node.is_size:
                kind, sort = Kind.Constant, "size"
            name, title, whole = (
                getattr(node, "name", None),
                getattr(node, "title", None),
                node.span,
            )
            own = (
                Span(whole.file, whole.start, whole.start + len(sort), whole.line, whole.column)
                if name is None
                else name.span
            )
            detail = (sort if title is None else title.text) if name is not None else None
            inside = _symbols(
                (child for part in INSIDE for child in getattr(node, part, ())), lines
            )
            around = lines.range(min(whole.start, own.start), max(whole.end, own.end))
            symbol = types.DocumentSymbol(
                name.text if name else sort,
                kind,
                around,
                lines.span(own),
                detail=detail,
                children=inside or None,
            )
            found.append(symbol)
    return found

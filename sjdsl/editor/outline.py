"""The outline of a text: its symbols as a tree."""

from collections.abc import Iterable
from typing import Any

from lsprotocol import types

from sjdsl.compiler import ast
from sjdsl.compiler.diagnostics.source import Span
from sjdsl.editor.analysis import Analysis
from sjdsl.editor.positions import Lines

Kind = types.SymbolKind
SYMBOLS: dict[type[object], tuple[types.SymbolKind, str]] = {  # a symbol and its keyword
    ast.Game: (Kind.Module, "game"),
    ast.Constant: (Kind.Number, "param"),
    ast.Kind: (Kind.Class, "kind"),
    ast.Group: (Kind.Interface, "group"),
    ast.Movers: (Kind.Class, "movers"),
    ast.Agents: (Kind.Class, "agents"),
    ast.Field: (Kind.Field, "field"),
    ast.Task: (Kind.Object, "task"),
    ast.TaskField: (Kind.Field, "field"),
    ast.HoldOut: (Kind.Object, "hold out"),
    ast.Timer: (Kind.Field, "timer"),
    ast.Action: (Kind.EnumMember, "action"),
    ast.Shape: (Kind.Struct, "shape"),
    ast.Define: (Kind.Function, "define"),
    ast.Phase: (Kind.Method, "phase"),
    ast.Map: (Kind.Array, "map"),
    ast.Schedule: (Kind.Array, "schedule"),
    ast.Observe: (Kind.Object, "observe"),
    ast.Metrics: (Kind.Object, "metrics"),
    ast.Event: (Kind.Event, "event"),
    ast.Measure: (Kind.Variable, "metric"),
    ast.Checks: (Kind.Object, "checks"),
    ast.ScriptedPolicy: (Kind.Function, "policy"),
    ast.Scenario: (Kind.Object, "scenario"),
    ast.Variant: (Kind.Namespace, "variant"),
    ast.About: (Kind.String, "about"),
}
# Attributes of nodes that hold the declarations in them.
PARTS = ("sections", "attributes", "metrics", "changes", "fields")


def document_symbols(analysis: Analysis | None, lines: Lines) -> list[types.DocumentSymbol]:
    """Returns the declarations of a text, those inside others below them.

    Args:
      lines: of the text that is shown, which may be newer.
    """
    if analysis is None or analysis.file is None:
        return []
    return _symbols([analysis.file.game], lines)


def _symbols(nodes: Iterable[Any], lines: Lines) -> list[types.DocumentSymbol]:
    """Returns the symbols of those nodes that are declarations."""
    symbols: list[types.DocumentSymbol] = []
    for node in nodes:
        if isinstance(node, ast.Acts):
            symbols += _symbols(node.actions, lines)
        elif type(node) in SYMBOLS:
            symbols.append(_symbol(node, lines))
    return symbols


def _symbol(node: Any, lines: Lines) -> types.DocumentSymbol:
    """Returns the symbol of a declaration; one without a name is called by its keyword."""
    kind, keyword = SYMBOLS[type(node)]
    if isinstance(node, ast.Constant) and node.is_size:
        kind = Kind.Constant
        keyword = "size"
    whole = node.span
    name = getattr(node, "name", None)
    if name is None:
        selected = Span(
            whole.file, whole.start, whole.start + len(keyword), whole.line, whole.column
        )
        detail = None
    else:
        selected = name.span
        title = getattr(node, "title", None)
        detail = keyword if title is None else title.text
    children = [child for part in PARTS for child in getattr(node, part, ())]
    return types.DocumentSymbol(
        keyword if name is None else name.text,
        kind,
        lines.range(min(whole.start, selected.start), max(whole.end, selected.end)),
        lines.span(selected),
        detail=detail,
        children=_symbols(children, lines) or None,
    )

"""The outline of a text: its symbols as a tree."""

from collections.abc import Iterable

from lsprotocol import types

from sjdsl.compiler import ast
from sjdsl.compiler.diagnostics.source import Span
from sjdsl.editor.analysis import Analysis
from sjdsl.editor.positions import Lines

Kind = types.SymbolKind
SORTS: dict[type[object], tuple[types.SymbolKind, str]] = {
    ast.Kind: (Kind.Class, "kind"), ast.Group: (Kind.Interface, "group"), ast.Movers: (Kind.Class, "movers"),
    ast.Field: (Kind.Field, "field"), ast.Timer: (Kind.Field, "timer"), ast.Action: (Kind.EnumMember, "action"),
    ast.Shape: (Kind.Struct, "shape"), ast.Define: (Kind.Function, "define"), ast.Phase: (Kind.Method, "phase"),
    ast.Event: (Kind.Event, "event"), ast.Measure: (Kind.Variable, "metric"), ast.ScriptedPolicy: (Kind.Function, "policy"),
    ast.Scenario: (Kind.Object, "scenario"), ast.Variant: (Kind.Namespace, "variant"), ast.About: (Kind.String, "about"),
}  # fmt: skip
Names = list[types.DocumentSymbol]


def document_symbols(analysis: Analysis | None, lines: Lines) -> Names:
    """Returns the declarations of a text, those inside others below them. `lines`: of the text that is shown, which may be newer."""
    if analysis is None or analysis.file is None:
        return []
    game = analysis.file.game
    title = game.title.text if game.title is not None else ""
    return [_symbol(lines, game.name.text, title, Kind.Module, game.span, game.name.span, _sections(game.sections, lines))]


def _symbol(lines: Lines, name: str, detail: str, kind: types.SymbolKind, whole: Span, own: Span, inside: Names) -> types.DocumentSymbol:
    start, end = min(whole.start, own.start), max(whole.end, own.end)
    return types.DocumentSymbol(name, kind, lines.range(start, end), lines.span(own), detail=detail or None, children=inside or None)


def _sections(sections: Iterable[object], lines: Lines) -> Names:
    return [symbol for section in sections for symbol in _of(section, lines)]


def _of(node: object, lines: Lines) -> Names:
    """Returns the symbols of a declaration: itself with those inside it, or, of a block without a name, the block with them."""
    match node:
        case ast.Constant():
            kind, sort = (Kind.Constant, "size") if node.is_size else (Kind.Number, "param")
            return [_symbol(lines, node.name.text, sort, kind, node.span, node.name.span, [])]
        case ast.Kind() | ast.Movers():
            return [_named(node, lines, _sections(node.attributes, lines))]
        case ast.Variant():
            return [_named(node, lines, _sections(node.changes, lines), "" if node.title is None else node.title.text)]
        case ast.Agents():
            return [_block("agents", Kind.Class, node.span, _sections(node.attributes, lines), lines)]
        case ast.Acts():
            return _sections(node.actions, lines)
        case ast.Metrics():
            return [_block("metrics", Kind.Object, node.span, _sections(node.metrics, lines), lines)]
        case ast.Checks():
            return [_block("checks" if node.name is None else f"checks {node.name.text}", Kind.Object, node.span, [], lines)]
        case ast.Observe() | ast.Map() | ast.Schedule():
            kind = Kind.Object if isinstance(node, ast.Observe) else Kind.Array
            return [_block(type(node).__name__.lower(), kind, node.span, [], lines)]
        case _ if type(node) in SORTS:
            return [_named(node, lines, [])]
    return []


def _named(node: object, lines: Lines, inside: Names, detail: str = "") -> types.DocumentSymbol:
    kind, sort = SORTS[type(node)]
    name: ast.Name = node.name  # type: ignore[attr-defined]
    span: Span = node.span  # type: ignore[attr-defined]
    return _symbol(lines, name.text, detail or sort, kind, span, name.span, inside)


def _block(name: str, kind: types.SymbolKind, span: Span, inside: Names, lines: Lines) -> types.DocumentSymbol:
    word = Span(span.file, span.start, span.start + len(name.split()[0]), span.line, span.column)
    return _symbol(lines, name, "", kind, span, word, inside)

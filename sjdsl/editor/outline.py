"""The outline of a text: its symbols as a tree, the symbols of a whole folder, and what can be folded."""

import re
from collections.abc import Iterable, Iterator
from itertools import groupby, pairwise

from lsprotocol import types

from sjdsl.compiler import ast
from sjdsl.compiler.diagnostics.source import Span
from sjdsl.editor.analysis import Analysis
from sjdsl.editor.documents import Document
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


def workspace_symbols(query: str, files: Iterable[tuple[Document, ast.File]]) -> list[types.WorkspaceSymbol]:
    """Returns the declarations of several files whose names have the letters of `query` in their order."""
    fits = re.compile(".*".join(map(re.escape, "".join(query.lower().split()))))
    found = []
    for document, file in files:
        for symbol, around in _flat(_sections(file.game.sections, document.lines), file.game.name.text):
            if fits.search(symbol.name.lower()):
                location = types.Location(document.uri, symbol.selection_range)
                found.append(types.WorkspaceSymbol(location=location, name=symbol.name, kind=symbol.kind, container_name=around))
    return found


def _flat(tree: Names, around: str) -> Iterator[tuple[types.DocumentSymbol, str]]:
    for symbol in tree:
        yield symbol, around
        yield from _flat(list(symbol.children or []), symbol.name)


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


def folding(analysis: Analysis) -> list[types.FoldingRange]:
    """Returns what can be folded: blocks in braces over several lines, and comments of several lines; also of a text with mistakes."""
    lines, opened, found = analysis.document.lines, list[int](), []
    for token in analysis.tokens:
        line = lines.position(token.start_pos or 0).line
        if token.type == "LBRACE":
            opened.append(line)
        elif token.type == "RBRACE" and opened:
            first = opened.pop()
            if line - 1 > first:
                found.append(types.FoldingRange(first, line - 1))
    return sorted(found + _comments(analysis.document), key=lambda f: f.start_line)


def _comments(document: Document) -> list[types.FoldingRange]:
    """Returns runs of lines that hold only a comment."""
    starts = [*document.lines.starts, len(document.text)]
    comments = [document.text[start:end].lstrip().startswith("#") for start, end in pairwise(starts)]
    runs = [list(run) for is_comment, run in groupby(range(len(comments)), comments.__getitem__) if is_comment]
    return [types.FoldingRange(run[0], run[-1], kind=types.FoldingRangeKind.Comment) for run in runs if len(run) > 1]

"""Semantic tokens: the colour of each word by what it means, not by how it is spelt."""

from collections.abc import Iterator

from lsprotocol import types

from sjdsl.compiler import ast
from sjdsl.compiler.ast.names import Names, Occurrence, Symbol
from sjdsl.compiler.diagnostics.tree import walk
from sjdsl.compiler.elaborate.occurrences import occurrences
from sjdsl.compiler.syntax.parse import automaton
from sjdsl.editor.analysis import Analysis

TYPES = (
    "keyword", "comment", "string", "number", "operator", "namespace", "class", "interface", "struct", "enumMember", "function", "method",
    "property", "variable", "parameter", "event", "type",
)  # fmt: skip
MODIFIERS = ("declaration", "readonly", "defaultLibrary")
PLAIN = {"STRING": "string", "INT": "number", "DEC": "number"}
OPERATORS = ("CMP", "SIGN", "TIMES", "ARROW", "DOTS", "EQUAL")
SORTS = {
    "size": "parameter", "parameter": "parameter", "kind": "class", "sort of movers": "class", "group": "interface", "define": "function",
    "field of the world": "property",
}  # fmt: skip
SPACES = {
    "game": "namespace", "variant": "namespace", "word": "enumMember", "field": "property", "action": "enumMember", "argument": "property",
    "shape": "struct", "phase": "method", "metric": "event", "policy": "function", "scenario": "function", "checks": "namespace", "local": "variable",
}  # fmt: skip
LEGEND = types.SemanticTokensLegend(list(TYPES), list(MODIFIERS))
Coloured = tuple[int, int, str, tuple[str, ...]]  # from, to, type, modifiers


def semantic_tokens(analysis: Analysis) -> types.SemanticTokens:
    """Returns the words of a text in colours, each after the one before, as the protocol counts them."""
    lines = analysis.document.lines
    data: list[int] = []
    line = character = 0
    for start, end, sort, modifiers in coloured(analysis):
        at, until = lines.position(start), lines.position(end)
        if until.line != at.line:
            continue
        step = at.line - line
        data += [step, at.character - (character if step == 0 else 0), until.character - at.character, TYPES.index(sort)]
        data.append(sum(1 << MODIFIERS.index(m) for m in modifiers))
        line, character = at.line, at.character
    return types.SemanticTokens(data=data)


def coloured(analysis: Analysis) -> Iterator[Coloured]:
    """Yields the words of a text that have a colour, in its order; of a text with syntax errors by their spelling alone."""
    names = analysis.names if analysis.file is not None else Names()
    read = [] if analysis.file is None else occurrences(analysis.file, names)  # a colour needs no type, and waits for no elaboration
    named = {o.span.start: o for o in read}
    language = _words_as_names(analysis)
    for token in analysis.tokens:
        start, end = token.start_pos or 0, token.end_pos or 0
        if start in named:
            yield (start, end, *_named(named[start], names))
            continue
        is_word = automaton().words.get(token.type, "").isalpha()
        sort = PLAIN.get(token.type) or ("operator" if token.type in OPERATORS else "keyword" if is_word else "")
        if sort:
            yield (start, end, sort, ())
        elif start in language:
            yield (start, end, language[start], ("defaultLibrary",))


def _named(o: Occurrence, names: Names) -> tuple[str, tuple[str, ...]]:
    symbol: Symbol = o.symbols[0]
    sort = SORTS[names.sorts.get(symbol.name, "define")] if symbol.space == "name" else SPACES[symbol.space]
    fixed = symbol.space == "word" or (symbol.space == "name" and names.sorts.get(symbol.name) in ("size", "parameter"))
    return sort, tuple(["declaration"] * o.declares + ["readonly"] * fixed)


def _words_as_names(analysis: Analysis) -> dict[int, str]:
    """Returns where names of the language stand: units and types, functions, `agent`, `step`."""
    found: dict[int, str] = {}
    if analysis.file is None:
        return found
    for node in walk(analysis.file):
        match node:
            case ast.Constant(unit=name) | ast.NamedType(name=name) | ast.CellType(sort=name):
                found[name.span.start] = "type"
            case ast.Call() | ast.Extreme():
                found.setdefault(node.name.span.start, "function")
            case ast.Path(name=name) | ast.Domain(kind=name) if name.text in ("agent", "step", "other", "everyone"):
                found.setdefault(name.span.start, "variable")
    return found

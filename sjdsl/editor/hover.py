"""Hover: the declaration of a name, the value of a number, the meaning of a function."""

from typing import Any

from lsprotocol import types

from sjdsl.compiler import ir
from sjdsl.compiler.ast.names import Occurrence
from sjdsl.compiler.diagnostics.tree import walk
from sjdsl.compiler.ir.operations import FUNCTIONS
from sjdsl.doc.numbers import unit_of
from sjdsl.doc.wording import code, table_value
from sjdsl.editor.analysis import Analyses, Analysis
from sjdsl.editor.family import declarations
from sjdsl.editor.navigation import symbol_at

MAX_LINES = 14  # of a declaration
MAX_DECLARATIONS = 3


def hover(uri: str, position: types.Position, analyses: Analyses) -> types.Hover | None:
    """Returns the description of the name at a position, as Markdown.

    It is None for what is neither declared nor a function of the language.
    """
    analysis = analyses.of(uri)
    if analysis is None:
        return None
    lines = analysis.document.lines
    offset = lines.offset(position)
    token = next(
        (t for t in analysis.tokens if (t.start_pos or 0) <= offset < (t.end_pos or 0)), None
    )
    named = symbol_at(uri, position, analyses)
    text = ""
    if named is not None:
        named_in, occurrence = named
        text = _describe(named_in, occurrence, analyses)
    elif token is not None and token.type == "NAME" and str(token) in FUNCTIONS:
        uses = FUNCTIONS[str(token)].uses
        text = "  \n".join(f"`{expression}`: {meaning}" for expression, meaning in uses)
    if not text:
        return None
    range_ = None
    if token is not None:
        range_ = lines.range(token.start_pos or 0, token.end_pos or 0)
    return types.Hover(types.MarkupContent(types.MarkupKind.Markdown, text), range_)


def _describe(analysis: Analysis, occurrence: Occurrence, analyses: Analyses) -> str:
    """Returns the declarations of a name, its value if it is a number, and its other files."""
    paragraphs = []
    places = declarations(occurrence.symbols, analysis, analyses)[:MAX_DECLARATIONS]
    if places:
        code_lines = "\n".join(_declaration_text(text, o) for text, o in places)
        paragraphs.append(f"```sj\n{code_lines}\n```")
    symbol = occurrence.symbols[0]
    if analysis.build is not None and symbol.space == "name":
        game = analysis.build.game
        numbers: list[ir.Size | ir.Param] = [*game.sizes, *game.params]
        for number in numbers:
            if number.name == symbol.name:
                value = table_value(number.value, number.type.indexed_by)
                paragraphs.append(f"{code(symbol.name)} is {value} ({unit_of(number)})")
    elsewhere = dict.fromkeys(
        text.document.name.rpartition("/")[2] for text, _ in places if text is not analysis
    )
    if elsewhere:
        paragraphs.append(f"in {', '.join(elsewhere)}")
    return "\n\n".join(paragraphs)


def _declaration_text(analysis: Analysis, o: Occurrence) -> str:
    """Returns a declaration with the comment behind it, without its indentation.

    Of a long one, these are the first lines.
    """
    text = analysis.document.text
    nodes: list[Any] = [] if analysis.file is None else list(walk(analysis.file))
    span = o.span
    for node in nodes:  # the innermost declaration with this name comes last
        name = getattr(node, "name", None)
        if getattr(name, "span", None) == o.span:
            span = node.span
    rest_of_line = text[span.end :].partition("\n")[0]
    comment = rest_of_line if rest_of_line.lstrip().startswith("#") else ""
    indent = span.start - (text.rfind("\n", 0, span.start) + 1)
    first, *others = (text[span.start : span.end] + comment).splitlines()
    lines = [first]
    for line in others:
        own_indent = len(line) - len(line.lstrip())
        lines.append(line[min(indent, own_indent) :])
    if len(lines) > MAX_LINES:
        lines = [*lines[: MAX_LINES - 1], "…"]
    return "\n".join(lines)

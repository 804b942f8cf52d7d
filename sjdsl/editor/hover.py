"""Hover: a name's declaration and a number's value; what a function gives."""

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

MOST_LINES = 14  # of a declaration
MOST_DECLARATIONS = 3


def hover(uri: str, position: types.Position, analyses: Analyses) -> types.Hover | None:
    """Returns what there is to say of a name, as Markdown; None of what is neither declared nor a function."""
    analysis = analyses.of(uri)
    if analysis is None:
        return None
    offset = analysis.document.lines.offset(position)
    token = next(
        (t for t in analysis.tokens if (t.start_pos or 0) <= offset < (t.end_pos or 0)), None
    )
    found = symbol_at(uri, position, analyses)
    if found is not None:
        told = _declared(*found, analyses)
    elif token is not None and token.type == "NAME" and str(token) in FUNCTIONS:
        told = "  \n".join(f"`{written}`: {gives}" for written, gives in FUNCTIONS[str(token)].uses)
    else:
        told = ""
    if not told:
        return None
    range_ = (
        None
        if token is None
        else analysis.document.lines.range(token.start_pos or 0, token.end_pos or 0)
    )
    return types.Hover(types.MarkupContent(types.MarkupKind.Markdown, told), range_)


def _declared(analysis: Analysis, occurrence: Occurrence, analyses: Analyses) -> str:
    places = declarations(occurrence.symbols, analysis, analyses)[:MOST_DECLARATIONS]
    shown = "\n".join(_declaration_text(made, o) for made, o in places)
    numbers: list[ir.Size | ir.Param] = (
        [] if analysis.build is None else [*analysis.build.game.sizes, *analysis.build.game.params]
    )
    name = occurrence.symbols[0].name if occurrence.symbols[0].space == "name" else ""
    values = [
        f"{code(name)} is {table_value(n.value, n.type.by)} ({unit_of(n)})"
        for n in numbers
        if n.name == name
    ]
    elsewhere = dict.fromkeys(
        made.document.name.rpartition("/")[2] for made, _ in places if made is not analysis
    )
    return "\n\n".join(
        [
            *([f"```sj\n{shown}\n```"] if shown else []),
            *values,
            *([f"in {', '.join(elsewhere)}"] if elsewhere else []),
        ]
    )


def _declaration_text(analysis: Analysis, o: Occurrence) -> str:
    """Returns the lines of a declaration with the comment behind it, without their indentation; of a long one the beginning."""
    text = analysis.document.text
    nodes: list[Any] = [] if analysis.file is None else list(walk(analysis.file))
    around = [
        node.span for node in nodes if getattr(getattr(node, "name", None), "span", None) == o.span
    ]  # the smallest last
    whole = around[-1] if around else o.span
    rest = text[whole.end :].partition("\n")[0]
    comment = rest if rest.lstrip().startswith("#") else ""
    indent = whole.start - (text.rfind("\n", 0, whole.start) + 1)
    lines = (text[whole.start : whole.end] + comment).splitlines()
    lines = [lines[0], *(line[min(indent, len(line) - len(line.lstrip())) :] for line in lines[1:])]
    return "\n".join(lines if len(lines) <= MOST_LINES else [*lines[: MOST_LINES - 1], "…"])

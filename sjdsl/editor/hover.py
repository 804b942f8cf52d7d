"""Hover: a name's declaration, what a word of the language means, and the explanation of a message."""

import re
import tomllib
from collections.abc import Mapping
from functools import cache
from importlib.resources import files
from typing import Any

from lark import Token, UnexpectedCharacters
from lsprotocol import types

from sjdsl.compiler.ast.names import Occurrence
from sjdsl.compiler.diagnostics.explanations import explain
from sjdsl.compiler.diagnostics.tree import walk
from sjdsl.compiler.ir.operations import FUNCTIONS
from sjdsl.compiler.syntax.parse import automaton, parser
from sjdsl.editor.analysis import Analyses, Analysis
from sjdsl.editor.family import declarations
from sjdsl.editor.navigation import symbol_at

MOST_LINES = 14  # of a declaration
MOST_DECLARATIONS = 3


def hover(uri: str, position: types.Position, analyses: Analyses) -> types.Hover | None:
    """Returns what there is to say of a place, as Markdown: of the messages about it, of a name, of a word of the language."""
    analysis = analyses.of(uri)
    if analysis is None:
        return None
    offset = analysis.document.lines.offset(position)
    token = next((t for t in analysis.tokens if (t.start_pos or 0) <= offset < (t.end_pos or 0)), None)
    found = symbol_at(uri, position, analyses)
    told = _explained(analysis, offset)
    if found is not None:
        told += _declared(*found, analyses)
    elif token is not None:
        told += _word(token)
    if not told:
        return None
    range_ = None if token is None else analysis.document.lines.range(token.start_pos or 0, token.end_pos or 0)
    return types.Hover(types.MarkupContent(types.MarkupKind.Markdown, "\n\n---\n\n".join(told)), range_)


def _explained(analysis: Analysis, offset: int) -> list[str]:
    """Returns the explanations of the codes of messages at a place, of the game itself and of its variants."""
    codes = dict.fromkeys(
        d.code
        for _, problems in analysis.all_problems()
        for d in problems
        if d.span.file == analysis.document.name and d.span.start <= offset <= d.span.end
    )
    return [explain(code) for code in codes]


def _declared(analysis: Analysis, occurrence: Occurrence, analyses: Analyses) -> list[str]:
    places = declarations(occurrence.symbols, analysis, analyses)[:MOST_DECLARATIONS]
    shown = "\n".join(declaration_text(made, o) for made, o in places)
    told = [f"```sj\n{shown}\n```"] if shown else []
    elsewhere = [made.document.name.rpartition("/")[2] for made, _ in places if made is not analysis]
    told += [f"in {', '.join(dict.fromkeys(elsewhere))}"] * bool(elsewhere)
    return ["\n\n".join(told)] if told else []


def declaration_text(analysis: Analysis, o: Occurrence) -> str:
    """Returns the lines of a declaration with the comment behind it, without their indentation; of a long one the beginning."""
    text = analysis.document.text
    nodes: list[Any] = [] if analysis.file is None else list(walk(analysis.file))
    around = [node.span for node in nodes if getattr(getattr(node, "name", None), "span", None) == o.span]  # the smallest last
    whole = around[-1] if around else o.span
    rest = text[whole.end :].partition("\n")[0]
    comment = rest if rest.lstrip().startswith("#") else ""
    indent = whole.start - (text.rfind("\n", 0, whole.start) + 1)
    lines = (text[whole.start : whole.end] + comment).splitlines()
    lines = [lines[0], *(line[min(indent, len(line) - len(line.lstrip())) :] for line in lines[1:])]
    return "\n".join(lines if len(lines) <= MOST_LINES else [*lines[: MOST_LINES - 1], "…"])


# ---- words of the language


@cache
def meanings() -> Mapping[str, tuple[str, ...]]:
    """Returns for each word of the language the sentences of the manual that say what it means."""
    text = files("sjdsl.editor").joinpath("words.toml").read_text("utf-8")
    return {word: tuple(sentences) for word, sentences in tomllib.loads(text).items()}


@cache
def examples() -> Mapping[str, tuple[str, ...]]:
    """Returns for each word of the language lines of games that have it: the examples of the grammar."""
    grammar = files("sjdsl.grammar").joinpath("sj.lark").read_text("utf-8")
    table = automaton()
    found: dict[str, list[str]] = {}
    for example in (line[3:].strip() for line in grammar.splitlines() if line.startswith("// ") and not line.startswith("// -")):
        try:
            tokens = [] if example[:1].isupper() else list(parser().parse_interactive(example).lexer_thread.lex(None))
        except UnexpectedCharacters:  # it is a remark
            continue
        for word in {table.words.get(token.type, "") for token in tokens}:
            if word.isalpha():
                found.setdefault(word, []).append(example)
    return {word: tuple(sorted(lines, key=lambda e: (not e.startswith(word), len(e)))[:2]) for word, lines in found.items()}


def _word(token: Token) -> list[str]:
    if token.type == "NAME" and str(token) in FUNCTIONS:
        return ["  \n".join(f"`{written}`: {gives}" for written, gives in FUNCTIONS[str(token)].uses)]
    word = automaton().words.get(token.type, "")
    if not word.isalpha():
        return []
    said = re.sub(r"\[([^\]]*)\]\(#[^)]*\)", r"\1", "  \n".join(meanings().get(word, ())))  # links of the manual lead nowhere here
    shown = "\n".join(examples().get(word, ()))
    return ["\n\n".join(part for part in (f"**`{word}`**", said, f"```sj\n{shown}\n```" if shown else "") if part)]

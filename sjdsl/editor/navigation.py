"""Where a name is declared, where it is used, and its change everywhere at once; through the games that one extends."""

import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from lsprotocol import types

from sjdsl.compiler.ast.names import Occurrence
from sjdsl.compiler.diagnostics.problems import Problems
from sjdsl.compiler.elaborate.lookup import AGENT_ATTRIBUTES, CELL_ATTRIBUTES, NOWHERE
from sjdsl.compiler.ir.operations import FUNCTIONS
from sjdsl.compiler.syntax.parse import automaton
from sjdsl.compiler.syntax.read import inside_folder
from sjdsl.editor.analysis import Analyses, Analysis
from sjdsl.editor.documents import Documents
from sjdsl.editor.family import declarations, everywhere
from sjdsl.editor.positions import Moved
from sjdsl.runtime.actions import BUILT_IN, HEADINGS

NAME = re.compile(r"[a-z][a-z0-9_]*")
FIXED = {  # names that mean something of their own in the language, by name space
    "phase": ("start", "tick"), "action": BUILT_IN, "field": ("heading", *AGENT_ATTRIBUTES, *CELL_ATTRIBUTES),
    "policy": ("random", "never", "stay", "seek"),
    "word": ("agent", "cell", "no", "other", "everyone", "step", "yes", "outside", NOWHERE, *HEADINGS),
}  # fmt: skip


class Refused(Exception):
    """A name cannot be changed; the message says why."""


def symbol_at(
    uri: str, position: types.Position, analyses: Analyses
) -> tuple[Analysis, Occurrence] | None:
    """Returns the name at a position, in the text as it could be read last."""
    document, analysis = analyses.documents.get(uri), analyses.readable(uri)
    if document is None or analysis is None:
        return None
    offset = document.lines.offset(position)
    back = Moved(analysis.document.text, document.text)
    before = back.back(offset)
    here = [o for o in analysis.occurrences if o.span.start <= before <= o.span.end]
    found = max(here, key=lambda o: o.span.start, default=None)
    if found is None or document.text[
        back.start(found.span.start) : back.end(found.span.end)
    ] != _text(analysis, found):
        return None  # the name itself is being changed
    return analysis, found


def _text(analysis: Analysis, o: Occurrence) -> str:
    return analysis.document.text[o.span.start : o.span.end]


def _range(o: Occurrence, analysis: Analysis, documents: Documents) -> types.Range:
    """Returns where a name stands now, in the text as it is open."""
    now = documents.get(analysis.document.uri) or analysis.document
    if now.text == analysis.document.text:
        return now.lines.span(o.span)
    moved = Moved(analysis.document.text, now.text)
    return now.lines.range(moved.start(o.span.start), moved.end(o.span.end))


def definition(uri: str, position: types.Position, analyses: Analyses) -> list[types.Location]:
    """Returns where the name at a position is declared; of `extends "FILE"` and `map "FILE"` the file."""
    found = symbol_at(uri, position, analyses)
    if found is None:
        return _named_file(uri, position, analyses)
    analysis, occurrence = found
    places = declarations(occurrence.symbols, analysis, analyses)
    others = [
        (made, o) for made, o in places if (made is not analysis or o.span != occurrence.span)
    ]
    chosen = others if occurrence.declares and others else places
    return [
        types.Location(made.document.uri, _range(o, made, analyses.documents)) for made, o in chosen
    ]


def _named_file(uri: str, position: types.Position, analyses: Analyses) -> list[types.Location]:
    analysis = analyses.of(uri)
    if analysis is None:
        return []
    offset = analysis.document.lines.offset(position)
    for before, token in zip(analysis.tokens, analysis.tokens[1:], strict=False):
        is_here = (token.start_pos or 0) <= offset <= (token.end_pos or 0)
        if is_here and token.type == "STRING" and before.type in ("EXTENDS", "MAP", "WRAPS"):
            path = inside_folder(
                token[1:-1], analysis.source.span(0, 0), analysis.source, Problems()
            )
            start = types.Position(0, 0)
            if path is None or not path.is_file():
                return []
            return [types.Location(analyses.documents.uri(path), types.Range(start, start))]
    return []


def references(
    uri: str,
    position: types.Position,
    analyses: Analyses,
    folders: Iterable[Path],
    declared: bool = True,
) -> list[types.Location]:
    """Returns every place of the name at a position; with its declarations if `declared`."""
    found = symbol_at(uri, position, analyses)
    if found is None:
        return []
    analysis, occurrence = found
    hits = [
        (made, o)
        for made, all_ in everywhere(occurrence.symbols, analysis, analyses, folders)
        for o in all_
    ]
    shown = [(made, o) for made, o in hits if declared or not o.declares]
    return [
        types.Location(made.document.uri, _range(o, made, analyses.documents)) for made, o in shown
    ]


# ---- rename


def rename(
    uri: str, position: types.Position, new: str, analyses: Analyses, folders: Iterable[Path]
) -> types.WorkspaceEdit:
    """Returns the edits that give a thing another name, in every text.

    Raises Refused: there is no name at the position, or it belongs to the language; the text has syntax errors; the new name is not allowed,
    or is taken.
    """
    as_it_is = analyses.of(uri)
    if as_it_is is not None and as_it_is.file is None:
        raise Refused(
            "the text has syntax errors: repair them first, so that every place of the name is known"
        )
    found = symbol_at(uri, position, analyses)
    if found is None:
        raise Refused("there is no name here that the game declares")
    analysis, occurrence = found
    for symbol in occurrence.symbols:
        if symbol.name in FIXED.get(symbol.space, ()):
            raise Refused(
                f"`{symbol.name}` is a name of the language: it means something of its own"
            )
    if not NAME.fullmatch(new):
        raise Refused(
            f"`{new[:40]}` cannot be a name: names are small letters, digits and `_`, and begin with a letter"
        )
    table = automaton()
    if any(word == new for kind, word in table.words.items() if kind not in table.soft):
        raise Refused(f"`{new}` is a word of the language and cannot be a name")
    if new in FUNCTIONS or any(new in names for names in FIXED.values()):
        raise Refused(
            f"`{new}` means something of its own in the language and cannot be a name here"
        )
    documents, changes = analyses.documents, list[Any]()
    for made, hits in everywhere(occurrence.symbols, analysis, analyses, folders):
        if new != _text(analysis, occurrence) and any(
            token.type == "NAME" and token == new for token in made.tokens
        ):
            raise Refused(
                f"`{new}` already stands in {Path(made.document.name).name}, for something else"
            )
        now = documents.get(made.document.uri) or made.document
        edits: list[Any] = [types.TextEdit(_range(o, made, documents), new) for o in hits]
        changed = types.TextDocumentEdit(
            types.OptionalVersionedTextDocumentIdentifier(now.uri, now.version), edits
        )
        changes += [changed] if edits else []
    return types.WorkspaceEdit(document_changes=changes)

"""Where a name is declared and used, and renaming it, also in the games that a game extends."""

import re
from collections.abc import Iterable
from itertools import pairwise
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
FIXED = {  # names that have a meaning in the language, by name space
    "phase": ("start", "tick"), "action": BUILT_IN,
    "field": ("heading", *AGENT_ATTRIBUTES, *CELL_ATTRIBUTES),
    "policy": ("random", "never", "stay", "seek"),
    "word": (
        "agent", "cell", "no", "other", "everyone", "step", "yes", "outside", NOWHERE, *HEADINGS,
    ),
}  # fmt: skip


class Refused(Exception):
    """A name can't be changed; the message says why."""


def symbol_at(
    uri: str, position: types.Position, analyses: Analyses
) -> tuple[Analysis, Occurrence] | None:
    """Returns the name at a position, in the last analysis of the text without syntax errors.

    It is None if there is no name, or if the name has changed since.
    """
    document = analyses.documents.get(uri)
    analysis = analyses.readable(uri)
    if document is None or analysis is None:
        return None
    change = Moved(analysis.document.text, document.text)
    offset = change.back(document.lines.offset(position))
    touching = [o for o in analysis.occurrences if o.span.start <= offset <= o.span.end]
    if not touching:
        return None
    occurrence = max(touching, key=lambda o: o.span.start)
    start = change.start(occurrence.span.start)
    end = change.end(occurrence.span.end)
    if document.text[start:end] != _spelling(analysis, occurrence):
        return None
    return analysis, occurrence


def _spelling(analysis: Analysis, o: Occurrence) -> str:
    return analysis.document.text[o.span.start : o.span.end]


def _range(o: Occurrence, analysis: Analysis, documents: Documents) -> types.Range:
    """Returns the range of a name in the text as it is now; its analysis may be older."""
    document = documents.get(analysis.document.uri) or analysis.document
    if document.text == analysis.document.text:
        return document.lines.span(o.span)
    change = Moved(analysis.document.text, document.text)
    return document.lines.range(change.start(o.span.start), change.end(o.span.end))


def definition(uri: str, position: types.Position, analyses: Analyses) -> list[types.Location]:
    """Returns where the name at a position is declared.

    For `extends "FILE"` and `map "FILE"`, that is the file.
    """
    named = symbol_at(uri, position, analyses)
    if named is None:
        return _named_file(uri, position, analyses)
    analysis, occurrence = named
    places = declarations(occurrence.symbols, analysis, analyses)
    if occurrence.declares:
        others = [
            (text, o) for text, o in places if text is not analysis or o.span != occurrence.span
        ]
        places = others or places
    return [_location(text, o, analyses) for text, o in places]


def _location(analysis: Analysis, o: Occurrence, analyses: Analyses) -> types.Location:
    return types.Location(analysis.document.uri, _range(o, analysis, analyses.documents))


def _named_file(uri: str, position: types.Position, analyses: Analyses) -> list[types.Location]:
    """Returns the base or map whose file name stands at a position."""
    analysis = analyses.of(uri)
    if analysis is None:
        return []
    offset = analysis.document.lines.offset(position)
    for keyword, token in pairwise(analysis.tokens):
        is_at_position = (token.start_pos or 0) <= offset <= (token.end_pos or 0)
        is_file = token.type == "STRING" and keyword.type in ("EXTENDS", "MAP", "WRAPS")
        if is_at_position and is_file:
            source = analysis.source
            path = inside_folder(token[1:-1], source.span(0, 0), source, Problems())
            if path is None or not path.is_file():
                return []
            start = types.Position(0, 0)
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
    named = symbol_at(uri, position, analyses)
    if named is None:
        return []
    analysis, occurrence = named
    locations: list[types.Location] = []
    for text, names in everywhere(occurrence.symbols, analysis, analyses, folders):
        locations += [_location(text, o, analyses) for o in names if declared or not o.declares]
    return locations


# ---- rename


def rename(
    uri: str, position: types.Position, new: str, analyses: Analyses, folders: Iterable[Path]
) -> types.WorkspaceEdit:
    """Returns the edits that rename what stands at a position, in every text.

    Raises:
      Refused: there is no name at the position, or it belongs to the language; the text has syntax
        errors; the new name isn't allowed, or is taken.
    """
    current = analyses.of(uri)
    if current is not None and current.file is None:
        raise Refused(
            "the text has syntax errors: repair them first, so that every place of the name is "
            "known"
        )
    named = symbol_at(uri, position, analyses)
    if named is None:
        raise Refused("there is no name here that the game declares")
    analysis, occurrence = named
    for symbol in occurrence.symbols:
        if symbol.name in FIXED.get(symbol.space, ()):
            raise Refused(
                f"`{symbol.name}` is a name of the language: it means something of its own"
            )
    if not NAME.fullmatch(new):
        raise Refused(
            f"`{new[:40]}` cannot be a name: names are small letters, digits and `_`, and begin "
            "with a letter"
        )
    table = automaton()
    if any(word == new for kind, word in table.words.items() if kind not in table.soft):
        raise Refused(f"`{new}` is a word of the language and cannot be a name")
    if new in FUNCTIONS or any(new in names for names in FIXED.values()):
        raise Refused(
            f"`{new}` means something of its own in the language and cannot be a name here"
        )
    documents = analyses.documents
    is_other_name = new != _spelling(analysis, occurrence)
    changes: list[Any] = []
    for text, names in everywhere(occurrence.symbols, analysis, analyses, folders):
        if is_other_name and any(t.type == "NAME" and t == new for t in text.tokens):
            raise Refused(
                f"`{new}` already stands in {Path(text.document.name).name}, for something else"
            )
        if names:
            document = documents.get(text.document.uri) or text.document
            versioned = types.OptionalVersionedTextDocumentIdentifier(
                document.uri, document.version
            )
            edits: list[Any] = [types.TextEdit(_range(o, text, documents), new) for o in names]
            changes.append(types.TextDocumentEdit(versioned, edits))
    return types.WorkspaceEdit(document_changes=changes)

"""Edits of a text that an editor offers: the changes that messages suggest, and the lines that `sjdsl fmt` would change."""

from difflib import SequenceMatcher
from itertools import accumulate
from typing import Any

from lsprotocol import types

from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.editor.analysis import Analysis
from sjdsl.editor.diagnostics import by_variant, diagnostics
from sjdsl.editor.documents import Documents
from sjdsl.format import format_source


def quick_fixes(
    analysis: Analysis, range_: types.Range, documents: Documents
) -> list[types.CodeAction]:
    """Returns what the messages about a range suggest, in all variants."""
    lines, own = analysis.document.lines, analysis.document.name
    start, end = lines.offset(range_.start), lines.offset(range_.end)
    told = [
        (d, v)
        for d, v in by_variant(analysis.all_problems())
        if d.span.file == own and d.span.start <= end and start <= d.span.end
    ]
    found = []
    for d, variants in told:
        shown = diagnostics(analysis, documents, [(variants[:1], [d])])
        inside = [
            suggestion
            for suggestion in d.suggestions
            if all(edit.span.file == own for edit in suggestion.edits)
        ]
        for number, suggestion in enumerate(inside):
            edits: list[Any] = [
                types.TextEdit(lines.span(edit.span), edit.text) for edit in suggestion.edits
            ]
            versioned = types.OptionalVersionedTextDocumentIdentifier(
                analysis.document.uri, analysis.document.version
            )
            found.append(
                types.CodeAction(
                    title=suggestion.says[:1].upper() + suggestion.says[1:],
                    kind=types.CodeActionKind.QuickFix,
                    diagnostics=shown,
                    is_preferred=number == 0
                    and len(told) == 1
                    and (len(inside) == 1 or d.fix is not None),
                    edit=types.WorkspaceEdit(
                        document_changes=[types.TextDocumentEdit(versioned, edits)]
                    ),
                )
            )
    return found


def formatting(analysis: Analysis) -> list[types.TextEdit]:
    """Returns the edits that lay out a text, of no other lines, so that the cursor stays where it is; none for one with syntax errors."""
    before = analysis.document.text
    try:
        after = format_source(analysis.source)
    except CompileError:
        return []
    old, new = before.splitlines(keepends=True), after.splitlines(keepends=True)
    starts, lines = [0, *accumulate(map(len, old))], analysis.document.lines
    return [
        types.TextEdit(lines.range(starts[i], starts[j]), "".join(new[first:last]))
        for tag, i, j, first, last in SequenceMatcher(None, old, new, autojunk=False).get_opcodes()
        if tag != "equal"
    ]

"""Quick fixes: the changes that messages suggest, as edits of the text."""

from typing import Any

from lsprotocol import types

from sjdsl.editor.analysis import Analysis
from sjdsl.editor.diagnostics import by_variant, diagnostics
from sjdsl.editor.documents import Documents


def quick_fixes(analysis: Analysis, range_: types.Range, documents: Documents) -> list[types.CodeAction]:
    """Returns what the messages about a range suggest, in all variants. Some suggestions are compiled first: it is asked for seldom."""
    lines, own = analysis.document.lines, analysis.document.name
    start, end = lines.offset(range_.start), lines.offset(range_.end)
    told = [(d, v) for d, v in by_variant(analysis.all_problems()) if d.span.file == own and d.span.start <= end and start <= d.span.end]
    found = []
    for d, variants in told:
        shown = diagnostics(analysis, documents, [(variants[:1], [d])])
        inside = [suggestion for suggestion in d.suggestions if all(edit.span.file == own for edit in suggestion.edits)]
        for number, suggestion in enumerate(inside):
            edits: list[Any] = [types.TextEdit(lines.span(edit.span), edit.text) for edit in suggestion.edits]
            versioned = types.OptionalVersionedTextDocumentIdentifier(analysis.document.uri, analysis.document.version)
            found.append(
                types.CodeAction(
                    title=suggestion.says[:1].upper() + suggestion.says[1:],
                    kind=types.CodeActionKind.QuickFix,
                    diagnostics=shown,
                    is_preferred=number == 0 and len(told) == 1,
                    edit=types.WorkspaceEdit(document_changes=[types.TextDocumentEdit(versioned, edits)]),
                )
            )
    return found

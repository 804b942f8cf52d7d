"""Quick fixes: the changes that messages suggest, as edits of the text."""

from collections.abc import Iterator, Sequence

from lsprotocol import types

from sjdsl.compiler.diagnostics.diagnostic import Diagnostic, Suggestion
from sjdsl.editor.analysis import Analysis
from sjdsl.editor.diagnostics import by_variant, diagnostics
from sjdsl.editor.documents import Document, Documents


def quick_fixes(analysis: Analysis, range_: types.Range, documents: Documents) -> list[types.CodeAction]:
    """Returns what the messages about a range suggest, in all variants. Some suggestions are compiled first: it is asked for seldom."""
    lines, own = analysis.document.lines, analysis.document.name
    start, end = lines.offset(range_.start), lines.offset(range_.end)
    told = [(d, v) for d, v in by_variant(analysis.all_problems()) if d.span.file == own and d.span.start <= end and start <= d.span.end]
    found = []
    for d, variants in told:
        shown = diagnostics(analysis, documents, [(variants[:1], [d])])
        for number, suggestion in enumerate(_of(d, own)):
            action = _action(suggestion, shown, analysis.document)
            action.is_preferred = number == 0 and len(told) == 1
            found.append(action)
    return found


def _of(d: Diagnostic, own: str) -> Iterator[Suggestion]:
    """Yields the suggestions of a message that change nothing but the text itself."""
    for suggestion in d.suggestions:
        if all(edit.span.file == own for edit in suggestion.edits):
            yield suggestion


def _action(suggestion: Suggestion, shown: Sequence[types.Diagnostic], document: Document) -> types.CodeAction:
    edits: list[types.TextEdit | types.AnnotatedTextEdit | types.SnippetTextEdit] = [
        types.TextEdit(document.lines.span(edit.span), edit.text) for edit in suggestion.edits
    ]
    changed = types.TextDocumentEdit(types.OptionalVersionedTextDocumentIdentifier(document.uri, document.version), edits)
    title = suggestion.says[:1].upper() + suggestion.says[1:]
    return types.CodeAction(title, types.CodeActionKind.QuickFix, list(shown), edit=types.WorkspaceEdit(document_changes=[changed]))

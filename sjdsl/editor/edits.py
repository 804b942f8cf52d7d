"""Edits that an editor offers: those that messages suggest, and those of `sjdsl fmt`."""

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
    document = analysis.document
    start = document.lines.offset(range_.start)
    end = document.lines.offset(range_.end)
    problems = [
        (d, variants)
        for d, variants in by_variant(analysis.all_problems())
        if d.span.file == document.name and d.span.start <= end and start <= d.span.end
    ]
    versioned = types.OptionalVersionedTextDocumentIdentifier(document.uri, document.version)
    actions = []
    for d, variants in problems:
        shown = diagnostics(analysis, documents, [(variants[:1], [d])])
        suggestions = [
            suggestion
            for suggestion in d.suggestions
            if all(edit.span.file == document.name for edit in suggestion.edits)
        ]
        is_clear = len(problems) == 1 and (len(suggestions) == 1 or d.fix is not None)
        for number, suggestion in enumerate(suggestions):
            edits: list[Any] = [
                types.TextEdit(document.lines.span(edit.span), edit.text)
                for edit in suggestion.edits
            ]
            changes = [types.TextDocumentEdit(versioned, edits)]
            action = types.CodeAction(
                title=suggestion.says[:1].upper() + suggestion.says[1:],
                kind=types.CodeActionKind.QuickFix,
                diagnostics=shown,
                is_preferred=number == 0 and is_clear,
                edit=types.WorkspaceEdit(document_changes=changes),
            )
            actions.append(action)
    return actions


def formatting(analysis: Analysis) -> list[types.TextEdit]:
    """Returns the edits that format a text; none if it has syntax errors.

    They change only lines that differ, so that the cursor stays where it is.
    """
    try:
        formatted = format_source(analysis.source)
    except CompileError:
        return []
    document = analysis.document
    old = document.text.splitlines(keepends=True)
    new = formatted.splitlines(keepends=True)
    offsets = [0, *accumulate(map(len, old))]  # of the beginning of each line
    matcher = SequenceMatcher(None, old, new, autojunk=False)
    edits = []
    for tag, old_first, old_end, new_first, new_end in matcher.get_opcodes():
        if tag != "equal":
            range_ = document.lines.range(offsets[old_first], offsets[old_end])
            edits.append(types.TextEdit(range_, "".join(new[new_first:new_end])))
    return edits

"""Formatting as an editor applies it: the lines that `sjdsl fmt` would change, and no others, so that the cursor stays where it is."""

from difflib import SequenceMatcher

from lsprotocol import types

from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.editor.analysis import Analysis
from sjdsl.format import format_source


def formatting(analysis: Analysis) -> list[types.TextEdit]:
    """Returns the edits that lay out a text; none for one with syntax errors."""
    before = analysis.document.text
    try:
        after = format_source(analysis.source)
    except CompileError:
        return []
    old, new = before.splitlines(keepends=True), after.splitlines(keepends=True)
    starts = [0]
    for line in old:
        starts.append(starts[-1] + len(line))
    lines = analysis.document.lines
    return [
        types.TextEdit(lines.range(starts[i], starts[j]), "".join(new[first:last]))
        for tag, i, j, first, last in SequenceMatcher(None, old, new, autojunk=False).get_opcodes()
        if tag != "equal"
    ]

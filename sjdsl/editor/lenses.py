"""Code lenses: what can be run from the text, beside each phase and each check."""

from lsprotocol import types

from sjdsl.compiler import ast
from sjdsl.compiler.diagnostics.source import Span
from sjdsl.editor.analysis import Analysis

RUN_PHASE = "sjdsl.runPhase"
RUN_CHECK = "sjdsl.runCheck"
RUN_CHECKS = "sjdsl.runChecks"


def code_lenses(analysis: Analysis) -> list[types.CodeLens]:
    """Returns what can be run, also of variants; nothing for a text with syntax errors."""
    return [] if analysis.file is None else _of(analysis.file.game.sections, analysis)


def _of(sections: tuple[ast.Section | ast.Override | ast.Drop, ...], analysis: Analysis) -> list[types.CodeLens]:
    uri, found = analysis.document.uri, []
    for section in sections:
        match section:
            case ast.Phase():
                found.append(_lens(section.span, "run this phase's scenes", RUN_PHASE, [uri, section.name.text], analysis))
            case ast.Checks():
                found.append(_lens(section.span, "run all checks", RUN_CHECKS, [uri], analysis))
                found += [_lens(check.span, "run", RUN_CHECK, [uri, check.span.start], analysis) for check in section.checks]
            case ast.Variant():
                found += _of(section.changes, analysis)
    return found


def _lens(span: Span, title: str, command: str, arguments: list[object], analysis: Analysis) -> types.CodeLens:
    start = analysis.document.lines.position(span.start)
    return types.CodeLens(types.Range(start, start), types.Command(title, command, arguments=arguments))

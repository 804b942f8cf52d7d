"""Mistakes and warnings of a game and of all its variants, as an editor shows them."""

from collections.abc import Iterable, Sequence
from pathlib import Path

from lsprotocol import types

from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.diagnostic import Diagnostic
from sjdsl.compiler.diagnostics.explanations import FOLDER
from sjdsl.compiler.diagnostics.source import Span
from sjdsl.editor.analysis import Analysis
from sjdsl.editor.documents import Documents

SOURCE = "sjdsl"
SEVERITIES = {"error": types.DiagnosticSeverity.Error, "warning": types.DiagnosticSeverity.Warning}
WITHOUT_EFFECT = (errors.Unused, errors.KindAbsent, errors.IdleAction, errors.NeverCounted)

Found = Iterable[tuple[tuple[str, ...], Sequence[Diagnostic]]]


def by_variant(found: Found) -> list[tuple[Diagnostic, tuple[str, ...]]]:
    """Returns each mistake once, with the variants that alone have it; nothing where the game itself has it."""
    said: dict[tuple[object, ...], tuple[Diagnostic, list[str]]] = {}
    for variants, problems in found:
        for d in problems:
            key = (d.code, d.span, d.message)
            if key not in said:
                said[key] = (d, [])
            elif not said[key][1]:
                continue  # the game itself has it
            said[key][1].extend(["+".join(variants)] if variants else [])
    return [(d, tuple(names)) for d, names in said.values()]


def diagnostics(analysis: Analysis, documents: Documents, found: Found) -> list[types.Diagnostic]:
    """Returns what is wrong with a text, in its order. `found`: as far as it has been looked for."""
    told = by_variant(found)
    own = analysis.document.name
    if (
        analysis.document.path is None
    ):  # not saved, or an earlier version: which files belong to it isn't known
        told = [
            (d, variants)
            for d, variants in told
            if d.span.file == own and not isinstance(d, errors.NoFile)
        ]
    shown = [
        _diagnostic(d, variants, analysis, documents) for d, variants in told if d.span.file == own
    ]
    shown += [
        _elsewhere(d, variants, analysis, documents) for d, variants in told if d.span.file != own
    ]
    return sorted(shown, key=lambda d: (d.range.start.line, d.range.start.character, str(d.code)))


def _diagnostic(
    d: Diagnostic, variants: Sequence[str], analysis: Analysis, documents: Documents
) -> types.Diagnostic:
    many = "s" if len(variants) > 1 else ""
    among = f"in variant{many} {', '.join(f'`{name}`' for name in variants)}: " if variants else ""
    return types.Diagnostic(
        range=analysis.document.lines.span(d.span),
        message=f"{among}{d.message}" + (f"\nhelp: {d.hint}" if d.hint else ""),
        severity=SEVERITIES[d.severity],
        code=d.code,
        code_description=types.CodeDescription(href=(FOLDER / f"{d.code}.md").resolve().as_uri()),
        source=SOURCE,
        tags=[types.DiagnosticTag.Unnecessary] if isinstance(d, WITHOUT_EFFECT) else None,
        related_information=_related(
            [(label.span, label.text) for label in d.labels], analysis, documents
        )
        or None,
    )


def _elsewhere(
    d: Diagnostic, variants: Sequence[str], analysis: Analysis, documents: Documents
) -> types.Diagnostic:
    """A mistake in a base or a map stands where this text names the file, and points there."""
    shown = _diagnostic(d, variants, analysis, documents)
    shown.range = analysis.document.lines.range(*naming(d.span.file, analysis))
    shown.message = f"{Path(d.span.file).name}:{d.span.line}: {shown.message}"
    here = _related([(d.span, d.message)], analysis, documents)
    shown.related_information = [*here, *(shown.related_information or [])] or None
    shown.tags = None
    return shown


def naming(file: str, analysis: Analysis) -> tuple[int, int]:
    """Returns where a text names a file, or the base through which it comes; the game's name if it does not say."""
    game = None if analysis.file is None else analysis.file.game
    if game is None:
        return (0, 0)
    name = Path(file).name
    for token in analysis.tokens:
        if token.type == "STRING" and token.strip('"').endswith(name):
            return (token.start_pos or 0, token.end_pos or 0)
    span = game.name.span if game.extends is None else game.extends.span
    return (span.start, span.end)


def _related(
    places: Iterable[tuple[Span, str]], analysis: Analysis, documents: Documents
) -> list[types.DiagnosticRelatedInformation]:
    """Returns other places with what there is to say about them, in this text and in other files."""
    found = [(location(span, analysis, documents), text) for span, text in places]
    return [
        types.DiagnosticRelatedInformation(location=where, message=text)
        for where, text in found
        if where is not None
    ]


def location(span: Span, analysis: Analysis, documents: Documents) -> types.Location | None:
    """Returns where a span stands for an editor, None if its file cannot be named."""
    if span.file == analysis.document.name:
        return types.Location(analysis.document.uri, analysis.document.lines.span(span))
    path = Path(span.file)
    if not path.is_absolute():
        return None
    uri = documents.uri(path)
    document = documents.get(uri)
    line = types.Position(span.line - 1, 0)
    return types.Location(
        uri, types.Range(line, line) if document is None else document.lines.span(span)
    )

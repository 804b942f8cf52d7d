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

Problems = Iterable[tuple[tuple[str, ...], Sequence[Diagnostic]]]  # by the variants that have them


def by_variant(problems: Problems) -> list[tuple[Diagnostic, tuple[str, ...]]]:
    """Returns each problem once, with the variants that have it; with none if the game has it.

    Args:
      problems: those of the game without variants come first.
    """
    merged: dict[tuple[object, ...], tuple[Diagnostic, list[str]]] = {}
    for variants, diagnostics_of_variant in problems:
        for d in diagnostics_of_variant:
            key = (d.code, d.span, d.message)
            is_new = key not in merged
            _, names = merged.setdefault(key, (d, []))
            if variants and (is_new or names):
                names.append("+".join(variants))
    return [(d, tuple(names)) for d, names in merged.values()]


def diagnostics(
    analysis: Analysis, documents: Documents, problems: Problems
) -> list[types.Diagnostic]:
    """Returns the problems of a text as an editor shows them, in the order of the text."""
    document = analysis.document
    shown = []
    for d, variants in by_variant(problems):
        is_elsewhere = d.span.file != document.name
        # Which files belong to a text that isn't saved, or to an earlier version, isn't known.
        if document.path is None and (is_elsewhere or isinstance(d, errors.NoFile)):
            continue
        if is_elsewhere:
            shown.append(_diagnostic_elsewhere(d, variants, analysis, documents))
        else:
            shown.append(_diagnostic(d, variants, analysis, documents))
    return sorted(shown, key=lambda d: (d.range.start.line, d.range.start.character, str(d.code)))


def _diagnostic(
    d: Diagnostic, variants: Sequence[str], analysis: Analysis, documents: Documents
) -> types.Diagnostic:
    """Returns a problem of the text itself, with the variants that have it."""
    message = d.message
    if variants:
        names = ", ".join(f"`{name}`" for name in variants)
        message = f"in variant{'s' if len(variants) > 1 else ''} {names}: {message}"
    if d.hint:
        message += f"\nhelp: {d.hint}"
    related = _related([(label.span, label.text) for label in d.labels], analysis, documents)
    return types.Diagnostic(
        range=analysis.document.lines.span(d.span),
        message=message,
        severity=SEVERITIES[d.severity],
        code=d.code,
        code_description=types.CodeDescription(href=(FOLDER / f"{d.code}.md").resolve().as_uri()),
        source=SOURCE,
        tags=[types.DiagnosticTag.Unnecessary] if isinstance(d, WITHOUT_EFFECT) else None,
        related_information=related or None,
    )


def _diagnostic_elsewhere(
    d: Diagnostic, variants: Sequence[str], analysis: Analysis, documents: Documents
) -> types.Diagnostic:
    """Returns a problem of a base or a map: it is shown where the text names that file."""
    shown = _diagnostic(d, variants, analysis, documents)
    shown.range = analysis.document.lines.range(*_file_name_range(d.span.file, analysis))
    shown.message = f"{Path(d.span.file).name}:{d.span.line}: {shown.message}"
    related = _related([(d.span, d.message)], analysis, documents)
    shown.related_information = [*related, *(shown.related_information or [])] or None
    shown.tags = None
    return shown


def _file_name_range(file: str, analysis: Analysis) -> tuple[int, int]:
    """Returns the characters (first, after the last) in which a text names a file.

    If it doesn't, they are those of its base, or else of its own name.
    """
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
    """Returns other places, in this text or in other files, with a message for each."""
    related = []
    for span, text in places:
        location = _location(span, analysis, documents)
        if location is not None:
            related.append(types.DiagnosticRelatedInformation(location=location, message=text))
    return related


def _location(span: Span, analysis: Analysis, documents: Documents) -> types.Location | None:
    """Returns a span as an editor reads it, None if its file has no path."""
    if span.file == analysis.document.name:
        return types.Location(analysis.document.uri, analysis.document.lines.span(span))
    path = Path(span.file)
    if not path.is_absolute():
        return None
    uri = documents.uri(path)
    document = documents.get(uri)
    if document is not None:
        return types.Location(uri, document.lines.span(span))
    line = types.Position(span.line - 1, 0)
    return types.Location(uri, types.Range(line, line))

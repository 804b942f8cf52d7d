"""The files that share names: a text, the games that it extends, and those that extend these."""

from collections import defaultdict
from collections.abc import Collection, Iterable
from itertools import chain, islice
from pathlib import Path

from sjdsl.compiler.ast.names import Occurrence, Symbol, occurrences
from sjdsl.compiler.diagnostics.source import Source, Span
from sjdsl.editor.analysis import Analyses, Analysis
from sjdsl.files import games_below

MAX_FILES = 2000  # that are searched for games that extend another


def _readable(uris: Iterable[str], analyses: Analyses) -> list[Analysis]:
    """Returns the last analysis without syntax errors of each text."""
    candidates = map(analyses.readable, dict.fromkeys(uris))
    return [analysis for analysis in candidates if analysis is not None]


def _bases(analysis: Analysis, analyses: Analyses) -> list[Analysis]:
    """Returns the games that a text extends, the nearest first."""
    files = [source.file for source, _ in analysis.chain[1:] if source.file is not None]
    return _readable(map(analyses.documents.uri, files), analyses)


def declarations(
    symbols: Iterable[Symbol], analysis: Analysis, analyses: Analyses
) -> list[tuple[Analysis, Occurrence]]:
    """Returns where symbols are declared: in the text itself, then in its bases."""
    wanted = set(symbols)
    texts = [analysis]
    if all(symbol.space != "local" for symbol in wanted):
        texts += _bases(analysis, analyses)
    declaring: list[tuple[Analysis, Occurrence]] = []
    for text in texts:
        declaring += [(text, o) for o in text.occurrences if o.declares and wanted & {*o.symbols}]
    return declaring


def everywhere(
    symbols: Iterable[Symbol], analysis: Analysis, analyses: Analyses, folders: Iterable[Path]
) -> list[tuple[Analysis, list[Occurrence]]]:
    """Returns where symbols are named, by text.

    The texts are this one, its bases, and those that extend the one of these that declares a
    symbol. A field that several kinds of a group have counts as one: a name of it for one kind is a
    name of it for all.

    Args:
      folders: where to search for games that extend the text or its bases.
    """
    wanted = set(symbols)
    if any(symbol.space == "local" for symbol in wanted):
        return [(analysis, [o for o in analysis.occurrences if wanted & {*o.symbols}])]
    files = _files(analysis)
    below = islice(chain.from_iterable(map(games_below, folders)), MAX_FILES)
    uris = [
        analysis.document.uri,
        *(base.document.uri for base in _bases(analysis, analyses)),
        *(document.uri for document in analyses.documents),
        *(analyses.documents.uri(path.resolve()) for path in below),
    ]
    family = [
        text for text in _readable(uris, analyses) if text is analysis or files & _files(text)
    ]
    # Games that extend a base may use one of its defines for other kinds.
    resolved = defaultdict[Span, set[Symbol]](set)
    for text in family:
        for span, symbols_there in text.resolved.items():
            resolved[span] |= symbols_there
    wanted = _connected(wanted, resolved.values())
    named: list[tuple[Analysis, list[Occurrence]]] = []
    declaring: set[Path | str] = set()
    for text in family:
        if text.file is not None:
            names = occurrences(text.file, text.names, resolved)
            names = [o for o in names if wanted & {*o.symbols}]
            named.append((text, names))
            if any(o.declares for o in names):
                declaring.add(_file(text.source))
    return [(text, names) for text, names in named if declaring & files & _files(text)]


def _connected(symbols: set[Symbol], groups: Collection[set[Symbol]]) -> set[Symbol]:
    """Returns the symbols that share a group with one of `symbols`, directly or through others."""
    connected = set(symbols)
    while True:
        larger = connected.union(*(group for group in groups if connected & group))
        if larger == connected:
            return connected
        connected = larger


def _files(analysis: Analysis) -> set[Path | str]:
    """Returns the file of a text and of each game that it extends."""
    return {_file(analysis.source), *(_file(source) for source, _ in analysis.chain)}


def _file(source: Source) -> Path | str:
    """Returns the file of a text, links followed; its name if it isn't saved."""
    return source.file or source.name

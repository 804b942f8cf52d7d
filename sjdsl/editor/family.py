"""The files in which a name of one of them may stand: its own, those it extends, and all that extend one of these."""

from collections import defaultdict
from collections.abc import Iterable
from itertools import chain, islice
from pathlib import Path

from sjdsl.compiler.ast.names import Occurrence, Symbol, occurrences
from sjdsl.compiler.diagnostics.source import Source, Span
from sjdsl.editor.analysis import Analyses, Analysis
from sjdsl.files import games_below

MOST_FILES = 2000  # of the folders that are looked through for games that extend another


def readable(uris: Iterable[str], analyses: Analyses) -> list[Analysis]:
    """Returns what is known of texts when they had no syntax errors last, each once."""
    return [made for made in map(analyses.readable, dict.fromkeys(uris)) if made is not None]


def bases(analysis: Analysis, analyses: Analyses) -> list[Analysis]:
    """Returns what is known of the games that a text extends, the nearest first."""
    return readable(
        (
            analyses.documents.uri(source.file)
            for source, _ in analysis.chain[1:]
            if source.file is not None
        ),
        analyses,
    )


def declarations(
    symbols: Iterable[Symbol], analysis: Analysis, analyses: Analyses
) -> list[tuple[Analysis, Occurrence]]:
    """Returns where something is declared: in the text itself, then in its bases."""
    wanted = set(symbols)
    made = (
        [analysis]
        if any(s.space == "local" for s in wanted)
        else [analysis, *bases(analysis, analyses)]
    )
    return [
        (one, o) for one in made for o in one.occurrences if o.declares and wanted & set(o.symbols)
    ]


def everywhere(
    symbols: Iterable[Symbol], analysis: Analysis, analyses: Analyses, folders: Iterable[Path]
) -> list[tuple[Analysis, list[Occurrence]]]:
    """Returns where something is named: in the text, in its bases, and in all texts that stand on a file of these that declares it, perhaps nowhere.

    A field of several kinds that a group puts together is one thing: a name for one of them is a name for all.
    """
    wanted = set(symbols)
    if any(s.space == "local" for s in wanted):
        return [(analysis, [o for o in analysis.occurrences if wanted & set(o.symbols)])]
    files = _files(analysis)
    below = islice(chain.from_iterable(map(games_below, folders)), MOST_FILES)
    uris = [
        *(d.uri for d in analyses.documents),
        *(analyses.documents.uri(path.resolve()) for path in below),
    ]
    texts = readable(
        [analysis.document.uri, *(made.document.uri for made in bases(analysis, analyses)), *uris],
        analyses,
    )
    family = [made for made in texts if made is analysis or files & _files(made)]
    resolved = defaultdict[Span, set[Symbol]](
        set
    )  # a define of a base may be used for other kinds by games that stand on it
    for span, found in (pair for made in family for pair in made.resolved.items()):
        resolved[span] |= found
    known = 0
    while known < len(wanted):
        known = len(wanted)
        wanted |= {
            symbol for together in resolved.values() if wanted & together for symbol in together
        }
    read = [
        (made, [o for o in occurrences(made.file, made.names, resolved) if wanted & set(o.symbols)])
        for made in family
        if made.file
    ]
    declaring = {_file(made.source) for made, hits in read if any(o.declares for o in hits)} & files
    return [(made, hits) for made, hits in read if declaring & _files(made)]


def _files(analysis: Analysis) -> set[Path | str]:
    """Returns the file of a text and of each game that it extends."""
    return {
        _file(source) for source in (analysis.source, *(source for source, _ in analysis.chain))
    }


def _file(source: Source) -> Path | str:
    """Returns the file of a text, links followed; of one that is in no file, its name."""
    return source.file or source.name

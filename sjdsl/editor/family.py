"""The files in which a name of one of them may stand: its own, those it extends, and all that extend one of these."""

import os
from collections import defaultdict
from collections.abc import Iterable, Iterator
from pathlib import Path

from sjdsl.compiler.ast.names import Occurrence, Symbol
from sjdsl.compiler.diagnostics.source import Span
from sjdsl.editor.analysis import Analyses, Analysis

MOST_FILES = 2000  # of the folders that are looked through for games that extend another
PASSED = ("node_modules", "__pycache__")


def games_in(folders: Iterable[Path]) -> Iterator[Path]:
    """Yields the `.sj` files of folders and below, hidden folders left out, at most `MOST_FILES`."""
    number = 0
    for folder in folders:
        for at, inside, names in os.walk(folder):
            inside[:] = sorted(name for name in inside if not name.startswith(".") and name not in PASSED)
            for name in sorted(name for name in names if name.endswith(".sj")):
                number += 1
                if number > MOST_FILES:
                    return
                yield Path(at) / name


def all_texts(analyses: Analyses, folders: Iterable[Path]) -> dict[str, Analysis]:
    """Returns what is known of every open text and every game in folders, by URI: when it had no syntax errors last."""
    documents = analyses.documents
    uris = dict.fromkeys([*(d.uri for d in documents), *(documents.uri(path.resolve()) for path in games_in(folders))])
    found = {uri: analyses.readable(uri) for uri in uris}
    return {uri: analysis for uri, analysis in found.items() if analysis is not None}


def bases(analysis: Analysis, analyses: Analyses) -> dict[str, Analysis]:
    """Returns what is known of the games that a text extends, the nearest first, by URI."""
    uris = [analyses.documents.uri(Path(source.name)) for source, _ in analysis.chain[1:] if Path(source.name).is_absolute()]
    found = {uri: analyses.readable(uri) for uri in uris}
    return {uri: made for uri, made in found.items() if made is not None}


def declarations(symbols: Iterable[Symbol], analysis: Analysis, analyses: Analyses) -> list[tuple[Analysis, Occurrence]]:
    """Returns where something is declared: in the text itself, then in its bases."""
    wanted = set(symbols)
    made = [analysis] if any(s.space == "local" for s in wanted) else [analysis, *bases(analysis, analyses).values()]
    return [(one, o) for one in made for o in one.occurrences if o.declares and wanted & set(o.symbols)]


def everywhere(
    symbols: Iterable[Symbol], analysis: Analysis, analyses: Analyses, folders: Iterable[Path]
) -> list[tuple[Analysis, list[Occurrence]]]:
    """Returns where something is named: in the text, in its bases, and in all texts that stand on a file of these that declares it.

    A field of several kinds that a group puts together is one thing: a name for one of them is a name for all.
    """
    own, wanted = {source.name for source, _ in analysis.chain} | {analysis.document.name}, set(symbols)
    if any(s.space == "local" for s in wanted):
        return [(analysis, [o for o in analysis.occurrences if wanted & set(o.symbols)])]
    texts = {analysis.document.uri: analysis} | bases(analysis, analyses)
    texts = all_texts(analyses, folders) | texts
    family = [made for made in texts.values() if own & {source.name for source, _ in made.chain}]
    resolved = defaultdict[str, list[tuple[Span, Symbol]]](list)  # a define of a base may be used for other kinds by games that stand on it
    for span, symbol in (pair for made in family for pair in made.resolved):
        resolved[span.file].append((span, symbol))
    read = [(made, made.occurrences_with(resolved[made.document.name])) for made in family]
    known = 0
    while known < len(wanted):
        known = len(wanted)
        declaring = own & {made.document.name for made, found in read if any(o.declares and wanted & set(o.symbols) for o in found)}
        same = [(made, found) for made, found in read if made.document.name in own or declaring & {s.name for s, _ in made.chain}]
        wanted |= {symbol for _, found in same for o in found if wanted & set(o.symbols) for symbol in o.symbols}
    hits = [(made, [o for o in found if wanted & set(o.symbols)]) for made, found in same]
    return [(made, found) for made, found in hits if found]

"""One editor's session: its open texts and folders, and an answer for each thing it asks. Nothing here knows how messages travel."""

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path, PurePosixPath
from urllib.parse import urlsplit

from lsprotocol import types

from sjdsl.compiler.diagnostics.diagnostic import Diagnostic
from sjdsl.editor.analysis import Analyses, Analysis
from sjdsl.editor.completion import completion
from sjdsl.editor.diagnostics import diagnostics
from sjdsl.editor.documents import Document, Documents
from sjdsl.editor.edits import formatting, quick_fixes
from sjdsl.editor.hover import hover
from sjdsl.editor.navigation import definition, references, rename
from sjdsl.editor.outline import document_symbols
from sjdsl.editor.positions import UTF16

GAME = ".sj"


class Session:
    """The state of one client: `encoding`, the code units of its positions; `folders` that it has open.

    inside: the folders in which files are read, None for all.
    """

    def __init__(
        self,
        encoding: str = UTF16,
        folders: Iterable[Path] = (),
        inside: Sequence[Path] | None = None,
    ):
        self.documents = Documents(encoding, inside)
        self.analyses = Analyses(self.documents)
        self.folders = list(folders)

    # ---- texts

    def open(self, uri: str, text: str, version: int | None = None) -> None:
        """Opens a text, or replaces it."""
        self.documents.put(uri, text, version)

    def close(self, uri: str) -> None:
        self.documents.close(uri)
        self.analyses.forget(uri)

    def affected_by(self, uri: str) -> list[str]:
        """Returns the open games whose messages may differ when a text has changed: it itself, and those that stand on it."""
        path = self.documents.path(uri)
        games = [d.uri for d in self.documents if is_game(d)]
        standing = set(self.analyses.standing_on(path)) if path is not None else set()
        return [game for game in games if game == uri or game in standing]

    # ---- messages

    def diagnosed(self, uri: str) -> Iterator[list[types.Diagnostic]]:
        """Yields the messages about a text: of the game as it is, then with those of one variant after the other."""
        analysis = self.analyses.of(uri)
        if analysis is None:
            return
        found: list[tuple[tuple[str, ...], tuple[Diagnostic, ...]]] = []
        for variants, problems in analysis.all_problems():
            found.append((variants, problems))
            yield diagnostics(analysis, self.documents, found)

    def diagnostics(self, uri: str) -> list[types.Diagnostic]:
        """Returns all messages about a text, in all its variants."""
        return next(iter([*self.diagnosed(uri)][-1:]), [])

    # ---- questions

    def completion(self, uri: str, position: types.Position) -> list[types.CompletionItem]:
        return completion(uri, position, self.analyses)

    def hover(self, uri: str, position: types.Position) -> types.Hover | None:
        return hover(uri, position, self.analyses)

    def definition(self, uri: str, position: types.Position) -> list[types.Location]:
        return definition(uri, position, self.analyses)

    def references(
        self, uri: str, position: types.Position, declared: bool = True
    ) -> list[types.Location]:
        return references(uri, position, self.analyses, self.folders, declared)

    def rename(self, uri: str, position: types.Position, new: str) -> types.WorkspaceEdit:
        """Raises Refused with the reason why not."""
        return rename(uri, position, new, self.analyses, self.folders)

    def quick_fixes(self, uri: str, range_: types.Range) -> list[types.CodeAction]:
        return [
            fix
            for analysis in self._known(uri)
            for fix in quick_fixes(analysis, range_, self.documents)
        ]

    def formatting(self, uri: str) -> list[types.TextEdit]:
        return [edit for analysis in self._known(uri) for edit in formatting(analysis)]

    def _known(self, uri: str) -> list[Analysis]:
        """Returns what is known of a text; nothing if there is no such text."""
        analysis = self.analyses.of(uri)
        return [] if analysis is None else [analysis]

    def symbols(self, uri: str) -> list[types.DocumentSymbol]:
        document = self.documents.get(uri)
        readable = self.analyses.readable(uri)
        return [] if document is None else document_symbols(readable, document.lines)


def is_game(document: Document) -> bool:
    """Returns whether an open text is a game, and not a map that a game names."""
    suffix = PurePosixPath(urlsplit(document.uri).path).suffix
    return suffix == GAME or (suffix == "" and document.path is None)

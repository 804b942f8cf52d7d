"""One editor's session: its open texts and folders, and an answer to each of its questions.

How messages travel is the server's business.
"""

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path, PurePosixPath
from urllib.parse import urlsplit

from lsprotocol import types

from sjdsl.compiler.diagnostics.diagnostic import Diagnostic
from sjdsl.editor.analysis import Analyses
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
    """The state of one client.

    encoding: of its positions, see `Lines`; folders: that it has open.
    allowed: the folders in which files may be read; None: anywhere.
    """

    def __init__(
        self,
        encoding: str = UTF16,
        folders: Iterable[Path] = (),
        allowed: Sequence[Path] | None = None,
    ):
        self.documents = Documents(encoding, allowed)
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
        """Returns the open games that a change of a text affects: itself and those that read it."""
        path = self.documents.path(uri)
        depending = [] if path is None else self.analyses.depending_on(path)
        games = [document.uri for document in self.documents if is_game(document)]
        return [game for game in games if game == uri or game in depending]

    # ---- messages

    def diagnosed(self, uri: str) -> Iterator[list[types.Diagnostic]]:
        """Yields the messages about a text: without variants, then with those of more and more."""
        analysis = self.analyses.of(uri)
        if analysis is None:
            return
        problems: list[tuple[tuple[str, ...], tuple[Diagnostic, ...]]] = []
        for problems_of_variant in analysis.all_problems():
            problems.append(problems_of_variant)
            yield diagnostics(analysis, self.documents, problems)

    def diagnostics(self, uri: str) -> list[types.Diagnostic]:
        """Returns all messages about a text, in all its variants."""
        versions = list(self.diagnosed(uri))
        return versions[-1] if versions else []

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
        """Returns the edits of a new name. Raises Refused with a reason."""
        return rename(uri, position, new, self.analyses, self.folders)

    def quick_fixes(self, uri: str, range_: types.Range) -> list[types.CodeAction]:
        analysis = self.analyses.of(uri)
        return [] if analysis is None else quick_fixes(analysis, range_, self.documents)

    def formatting(self, uri: str) -> list[types.TextEdit]:
        analysis = self.analyses.of(uri)
        return [] if analysis is None else formatting(analysis)

    def symbols(self, uri: str) -> list[types.DocumentSymbol]:
        document = self.documents.get(uri)
        readable = self.analyses.readable(uri)
        return [] if document is None else document_symbols(readable, document.lines)


def is_game(document: Document) -> bool:
    """Returns whether an open text is a game, and not a map that a game names."""
    suffix = PurePosixPath(urlsplit(document.uri).path).suffix
    return suffix == GAME or (suffix == "" and document.path is None)

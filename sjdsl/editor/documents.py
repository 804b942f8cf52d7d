"""The texts that an editor has open and the files on the disk, by their URIs."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from urllib.parse import urlsplit
from urllib.request import url2pathname

from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.compiler.syntax.read import read_source
from sjdsl.editor.positions import UTF16, Lines


def path_of(uri: str) -> Path | None:
    """Returns the file that a URI names, links followed; None if it isn't one on the disk."""
    path = _path_in(uri)
    if path is None or urlsplit(uri).scheme != "file":
        return None
    return path.resolve()


def _path_in(uri: str) -> Path | None:
    """Returns the path in a URI, None if it has none that a file can have.

    A URI of another scheme may have a path too: of an earlier version, `git:/games/pond.sj?...`, or
    of a text that isn't saved yet.
    """
    parts = urlsplit(uri)
    try:
        path = Path(url2pathname(parts.path))
        path.resolve()
    except (OSError, RuntimeError, ValueError):  # RuntimeError: links that lead to each other
        return None
    is_remote = parts.scheme != "file" and parts.netloc
    return path if path.is_absolute() and not is_remote else None


@dataclass(frozen=True)
class Document:
    """One text.

    version: as the client counts, None for a file that isn't open.
    encoding: of positions, see `Lines`.
    path: its file, links followed, None if it isn't saved.
    uri_path: the path in its URI, beside which its maps and bases lie, None if there is none.
    """

    uri: str
    text: str
    version: int | None = None
    encoding: str = UTF16
    path: Path | None = None
    uri_path: Path | None = None

    @property
    def name(self) -> str:
        """The name that messages use."""
        if self.path is None or self.uri_path is None:
            return self.uri
        return self.uri_path.as_posix()

    @property
    def folder(self) -> Path | None:
        """The folder of its maps and bases."""
        return None if self.uri_path is None else self.uri_path.parent

    @cached_property
    def lines(self) -> Lines:
        """Converts its positions."""
        return Lines(self.text, self.encoding)


class Documents:
    """The open texts.

    encoding: of positions, see `Lines`.
    allowed: the folders in which files may be read; None: anywhere.
    """

    def __init__(self, encoding: str = UTF16, allowed: Sequence[Path] | None = None):
        self.encoding = encoding
        self._allowed = None if allowed is None else [folder.resolve() for folder in allowed]
        self._open: dict[str, Document] = {}
        self._uris: dict[Path, str] = {}  # of open texts, as the client escapes them

    def put(self, uri: str, text: str, version: int | None = None) -> Document:
        """Opens a text, or replaces it."""
        document = self._open[uri] = self._make_document(uri, text, version)
        if document.path is not None:
            self._uris[document.path] = uri
        return document

    def close(self, uri: str) -> None:
        """Forgets an open text; from then on its file is read."""
        document = self._open.pop(uri, None)
        if document is not None and document.path is not None:
            self._uris.pop(document.path, None)

    def __iter__(self) -> Iterator[Document]:
        yield from list(self._open.values())

    def is_open(self, uri: str) -> bool:
        return uri in self._open

    def get(self, uri: str) -> Document | None:
        """Returns an open text or the text of a file, None if there is neither."""
        if uri in self._open:
            return self._open[uri]
        path = self.path(uri)
        if path is None:
            return None
        if path in self._uris:
            return self._open[self._uris[path]]
        try:
            return self._make_document(uri, read_source(path).text, None)
        except CompileError:
            return None

    def path(self, uri: str) -> Path | None:
        """Returns the file that a URI names, None if it isn't on the disk or may not be read."""
        path = path_of(uri)
        return path if path is not None and self._may_read(path) else None

    def _make_document(self, uri: str, text: str, version: int | None) -> Document:
        """Returns a text; of its paths only those that may be read."""
        uri_path = _path_in(uri)
        if uri_path is not None and not self._may_read(uri_path.parent.resolve()):
            uri_path = None
        return Document(uri, text, version, self.encoding, self.path(uri), uri_path)

    def _may_read(self, path: Path) -> bool:
        return self._allowed is None or any(path.is_relative_to(folder) for folder in self._allowed)

    def uri(self, path: Path) -> str:
        """Returns the URI of a file, as the client wrote it if it is open."""
        return self._uris.get(path.resolve()) or path.as_uri()

    def text_over(self, path: Path) -> str | None:
        """Returns the text of a file that is open, None if it isn't."""
        uri = self._uris.get(path)
        return None if uri is None else self._open[uri].text

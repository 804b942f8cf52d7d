"""The texts that an editor has open, over the files on the disk, by their URIs."""

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
    """Returns the file that a URI names, links followed; None for one that is not on the disk, such as a text never saved."""
    place = place_of(uri)
    if place is None or urlsplit(uri).scheme != "file":
        return None
    return place.resolve()


def place_of(uri: str) -> Path | None:
    """Returns the path in a URI, None if it has none that a file can have.

    A URI of another scheme may have one too: of an earlier version, `git:/games/pond.sj?...`, or of a text that is not saved yet.
    """
    parts = urlsplit(uri)
    try:
        place = Path(url2pathname(parts.path))
        place.resolve()
    except (OSError, RuntimeError, ValueError):  # RuntimeError: links that lead to each other
        return None
    is_remote = parts.scheme != "file" and parts.netloc
    return place if place.is_absolute() and not is_remote else None


@dataclass(frozen=True)
class Document:
    """One text: `version` as the client counts, None for a file that is not open.

    path: the file that it is the text of, links followed; place: the path in its URI, beside which are its maps and bases. None where
    there is none.
    """

    uri: str
    text: str
    version: int | None = None
    encoding: str = UTF16
    path: Path | None = None
    place: Path | None = None

    @property
    def name(self) -> str:
        """What messages call it."""
        return self.uri if self.path is None or self.place is None else self.place.as_posix()

    @property
    def folder(self) -> Path | None:
        return None if self.place is None else self.place.parent

    @cached_property
    def lines(self) -> Lines:
        return Lines(self.text, self.encoding)


class Documents:
    """The open texts. `encoding`: the code units that the client counts in positions.

    inside: the folders in which files are read, None for all.
    """

    def __init__(self, encoding: str = UTF16, inside: Sequence[Path] | None = None):
        self.encoding = encoding
        self._inside = None if inside is None else [folder.resolve() for folder in inside]
        self._open: dict[str, Document] = {}
        self._uris: dict[
            Path, str
        ] = {}  # as the client writes them: it may escape more than others

    def put(self, uri: str, text: str, version: int | None = None) -> Document:
        """Opens a text, or replaces it."""
        document = self._open[uri] = self._document(uri, text, version)
        if document.path is not None:
            self._uris[document.path] = uri
        return document

    def close(self, uri: str) -> None:
        """Forgets an open text: from then on its file counts."""
        document = self._open.pop(uri, None)
        if document is not None and document.path is not None:
            self._uris.pop(document.path, None)

    def __iter__(self) -> Iterator[Document]:
        yield from list(self._open.values())

    def is_open(self, uri: str) -> bool:
        return uri in self._open

    def get(self, uri: str) -> Document | None:
        """Returns an open text, or a file as it is on the disk; None if there is neither, or no text."""
        if uri in self._open:
            return self._open[uri]
        path = self.path(uri)
        if path is None:
            return None
        if path in self._uris:
            return self._open[self._uris[path]]
        try:
            return self._document(uri, read_source(path).text, None)
        except CompileError:
            return None

    def path(self, uri: str) -> Path | None:
        """Returns the file that a URI names; None for one that is not on the disk, or that may not be read."""
        path = path_of(uri)
        return path if path is not None and self._may_read(path) else None

    def _document(self, uri: str, text: str, version: int | None) -> Document:
        place = place_of(uri)
        if place is not None and not self._may_read(place.parent.resolve()):
            place = None
        return Document(uri, text, version, self.encoding, self.path(uri), place)

    def _may_read(self, path: Path) -> bool:
        return self._inside is None or any(path.is_relative_to(folder) for folder in self._inside)

    def uri(self, path: Path) -> str:
        """Returns the URI of a file, as the client wrote it if it is open."""
        return self._uris.get(path.resolve()) or path.as_uri()

    def text_over(self, path: Path) -> str | None:
        """Returns the open text of a file, None if it is not open."""
        uri = self._uris.get(path)
        return None if uri is None else self._open[uri].text

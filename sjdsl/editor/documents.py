"""The texts that an editor has open, over the files on the disk, by their URIs."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from urllib.parse import urlsplit
from urllib.request import url2pathname

from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.compiler.syntax.read import read_source
from sjdsl.editor.positions import UTF16, Lines


def path_of(uri: str) -> Path | None:
    """Returns the file that a URI names, None for one that is not on the disk, such as a text never saved."""
    parts = urlsplit(uri)
    if parts.scheme != "file" or not parts.path:
        return None
    try:
        return Path(url2pathname(parts.path)).resolve()
    except (OSError, ValueError):  # a name that cannot be one of a file
        return None


@dataclass(frozen=True)
class Document:
    """One text: `version` as the client counts, None for a file that is not open. `name`: what messages call it."""

    uri: str
    text: str
    version: int | None = None
    encoding: str = UTF16

    @cached_property
    def path(self) -> Path | None:
        return path_of(self.uri)

    @property
    def name(self) -> str:
        return self.uri if self.path is None else self.path.as_posix()

    @cached_property
    def lines(self) -> Lines:
        return Lines(self.text, self.encoding)


class Documents:
    """The open texts. `encoding`: the code units that the client counts in positions."""

    def __init__(self, encoding: str = UTF16):
        self.encoding = encoding
        self._open: dict[str, Document] = {}
        self._uris: dict[Path, str] = {}  # as the client writes them: it may escape more than others

    def put(self, uri: str, text: str, version: int | None = None) -> Document:
        """Opens a text, or replaces it."""
        document = self._open[uri] = Document(uri, text, version, self.encoding)
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
        path = path_of(uri)
        if path is not None and path in self._uris:
            return self._open[self._uris[path]]
        if path is None:
            return None
        try:
            return Document(uri, read_source(path).text, None, self.encoding)
        except CompileError:
            return None

    def uri(self, path: Path) -> str:
        """Returns the URI of a file, as the client wrote it if it is open."""
        return self._uris.get(path) or path.as_uri()

    def text_over(self, path: Path) -> str | None:
        """Returns the open text of a file, None if it is not open."""
        uri = self._uris.get(path)
        return None if uri is None else self._open[uri].text

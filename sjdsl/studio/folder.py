"""The files that the studio opens and writes: games and maps in the folder it was started in."""

import hashlib
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from threading import Lock
from typing import NamedTuple

from sjdsl.files import games_below, line_end, read_bytes, write_whole

SUFFIXES = (".sj", ".txt")
LARGEST = 400_000  # bytes of a file
MAX_GAMES = 500  # that are listed
# The server answers in threads: of several that write a file from one state, one succeeds.
_writing = Lock()


class FileRefused(Exception):
    """A file can't be read or written; the message says why."""


class Changed(FileRefused):
    """A file has changed since it was read."""


class FileContent(NamedTuple):
    text: str
    digest: str


@dataclass(frozen=True)
class Folder:
    """A folder and all below it. root: its path, links followed."""

    root: Path

    def games(self) -> list[str]:
        """Returns the paths of the games below it, those in nearer folders first; at most 500."""
        games = islice(games_below(self.root), MAX_GAMES)
        return [path.relative_to(self.root).as_posix() for path in games]

    def read(self, name: str) -> FileContent:
        """Returns the content of a file. Raises FileRefused."""
        path = self.path_of(name)
        if not path.is_file():
            raise FileRefused(f"there is no file `{name}`")
        try:
            data = read_bytes(path, LARGEST)
            return FileContent(data.decode("utf-8"), digest(data))
        except OSError as error:
            raise FileRefused(f"`{name}` cannot be read: {error.strerror}") from None
        except UnicodeDecodeError:
            raise FileRefused(f"`{name}` is not text in UTF-8") from None

    def write(self, name: str, text: str, before: str | None) -> str:
        """Writes a file and returns its digest.

        The file keeps its line ends; those of the page's text are `\\n`.

        Args:
          before: the digest when the file was read, None for a new file.

        Raises:
          Changed: the file has another digest now.
          FileRefused: it can't be written.
        """
        path = self.path_of(name)
        with _writing:
            current = self.read(name) if path.is_file() else None
            if current and line_end(current.text) == "\r\n" and "\r" not in text:
                text = text.replace("\n", "\r\n")
            data = text.encode("utf-8")
            if len(data) > LARGEST:
                raise FileRefused(f"the text is larger than {LARGEST // 1000} kB")
            if current is None and before is not None:
                raise Changed(f"`{name}` is not there any more")
            if current is not None and current.digest != before:
                raise Changed(f"`{name}` was changed by somebody else since it was opened")
            try:
                write_whole(path, data)
            except OSError as error:
                raise FileRefused(f"`{name}` cannot be written: {error.strerror}") from None
        return digest(data)

    def path_of(self, name: str) -> Path:
        """Returns the path of a game or a map in the folder.

        Raises:
          FileRefused: it is another file, or lies outside, or is a link to a file outside.
        """
        try:
            name.encode("utf-8")  # a name that JSON can't hold
            path = (self.root / name).resolve()
            path.is_file()  # a name that the system refuses
        except (OSError, RuntimeError, ValueError):
            raise FileRefused(f"`{ascii(name[:80])[1:-1]}` is no path of a file") from None
        if not path.is_relative_to(self.root):
            verb = "is a link to a file" if (self.root / name).is_symlink() else "is"
            raise FileRefused(f"`{name}` {verb} outside the folder that the studio was started in")
        if path.suffix not in SUFFIXES:
            raise FileRefused(f"`{name}` is neither a game (.sj) nor a map (.txt)")
        return path


def digest(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()

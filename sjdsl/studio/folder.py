"""The files that the studio opens and writes: games and maps inside the folder it was started in."""

import hashlib
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from threading import Lock

from sjdsl.files import games_below, line_end, read_bytes, write_whole

SUFFIXES = (".sj", ".txt")
LARGEST = 400_000  # bytes of a file
MOST = 500  # files that are listed
_writing = (
    Lock()
)  # so that of several who write from the same text one succeeds: the server answers in threads


class FileRefused(Exception):
    """A file cannot be read or written; the text says why."""


class Changed(FileRefused):
    """A file is not as it was when it was read."""


@dataclass(frozen=True)
class Folder:
    """A folder and all below it. `root`: resolved."""

    root: Path

    def games(self) -> list[str]:
        """Returns the games, by their paths inside, those in nearer folders first; at most 500."""
        return [
            path.relative_to(self.root).as_posix() for path in islice(games_below(self.root), MOST)
        ]

    def read(self, name: str) -> tuple[str, str]:
        """Returns the text of a file and its digest. Raises FileRefused."""
        path = self.inside(name)
        if not path.is_file():
            raise FileRefused(f"there is no file `{name}`")
        try:
            data = read_bytes(path, LARGEST)
            return data.decode("utf-8"), digest(data)
        except OSError as error:
            raise FileRefused(f"`{name}` cannot be read: {error.strerror}") from None
        except UnicodeDecodeError:
            raise FileRefused(f"`{name}` is not text in UTF-8") from None

    def write(self, name: str, text: str, before: str | None) -> str:
        """Writes a file, with line ends as it had, and returns its digest: a page has no others than `\\n`.

        before: the digest when it was read; None for a file that is new. Raises Changed if it is not so any more, and FileRefused.
        """
        path = self.inside(name)
        with _writing:
            written, now = self.read(name) if path.is_file() else ("", None)
            if line_end(written) == "\r\n" and "\r" not in text:
                text = text.replace("\n", "\r\n")
            data = text.encode("utf-8")
            if len(data) > LARGEST:
                raise FileRefused(f"the text is larger than {LARGEST // 1000} kB")
            if now != before:
                raise Changed(
                    f"`{name}` was changed by somebody else since it was opened"
                    if now
                    else f"`{name}` is not there any more"
                )
            try:
                write_whole(path, data)
            except OSError as error:
                raise FileRefused(f"`{name}` cannot be written: {error.strerror}") from None
        return digest(data)

    def inside(self, name: str) -> Path:
        """Returns the path of a file in the folder. Raises FileRefused for one that is, or leads, outside, and for other sorts of files."""
        try:
            name.encode("utf-8")  # what JSON cannot hold, the page cannot either
            path = (self.root / name).resolve()
            path.is_file()  # the system refuses some names only when it is asked
        except (OSError, RuntimeError, ValueError):
            raise FileRefused(f"`{ascii(name[:80])[1:-1]}` is no path of a file") from None
        if not path.is_relative_to(self.root):
            is_ = "is a link to a file" if (self.root / name).is_symlink() else "is"
            raise FileRefused(f"`{name}` {is_} outside the folder that the studio was started in")
        if path.suffix not in SUFFIXES:
            raise FileRefused(f"`{name}` is neither a game (.sj) nor a map (.txt)")
        return path


def digest(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()

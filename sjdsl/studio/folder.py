"""The files that the studio opens and writes: games and maps inside the folder it was started in."""

import hashlib
import os
from dataclasses import dataclass
from pathlib import Path

SUFFIXES = (".sj", ".txt")
LARGEST = 400_000  # bytes of a file
MOST = 500  # files that are listed


class FileRefused(Exception):
    """A file cannot be read or written; the text says why."""


class Changed(FileRefused):
    """A file is not as it was when it was read."""


@dataclass(frozen=True)
class Folder:
    """A folder and all below it. `root`: resolved."""

    root: Path

    def games(self) -> list[str]:
        """Returns the games, by their paths inside; at most 500. Hidden folders are left out."""
        found = []
        for folder, inner, files in os.walk(self.root):
            inner[:] = sorted(name for name in inner if not name.startswith((".", "_")))
            found += [(Path(folder) / name).relative_to(self.root).as_posix() for name in sorted(files) if name.endswith(".sj")]
            if len(found) >= MOST:
                break
        return found[:MOST]

    def read(self, name: str) -> tuple[str, str]:
        """Returns the text of a file and its digest. Raises FileRefused."""
        path = self._inside(name)
        if not path.is_file():
            raise FileRefused(f"there is no file `{name}`")
        data = path.read_bytes()
        if len(data) > LARGEST:
            raise FileRefused(f"`{name}` is larger than {LARGEST // 1000} kB")
        try:
            return data.decode("utf-8"), digest(data)
        except UnicodeDecodeError:
            raise FileRefused(f"`{name}` is not text in UTF-8") from None

    def write(self, name: str, text: str, before: str | None) -> str:
        """Writes a file and returns its digest.

        before: the digest when it was read; None for a file that is new. Raises Changed if it is not so any more, and FileRefused.
        """
        path, data = self._inside(name), text.encode("utf-8")
        if len(data) > LARGEST:
            raise FileRefused(f"the text is larger than {LARGEST // 1000} kB")
        now = digest(path.read_bytes()) if path.is_file() else None
        if now != before:
            raise Changed(f"`{name}` was changed by somebody else since it was opened" if now else f"`{name}` is not there any more")
        beside = path.with_name(f".{path.name}.new")
        try:
            beside.write_bytes(data)
            os.replace(beside, path)  # the file is never half written
        except OSError as error:
            raise FileRefused(f"`{name}` cannot be written: {error.strerror}") from None
        return digest(data)

    def _inside(self, name: str) -> Path:
        """Returns the path of a file in the folder. Raises FileRefused for one that is, or leads, outside, and for other sorts of files."""
        path = (self.root / name).resolve()
        if not path.is_relative_to(self.root):
            raise FileRefused(f"`{name}` is outside the folder that the studio was started in")
        if path.suffix not in SUFFIXES:
            raise FileRefused(f"`{name}` is neither a game (.sj) nor a map (.txt)")
        return path


def digest(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()

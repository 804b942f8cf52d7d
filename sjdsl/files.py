"""Finds, reads and writes files: a file is written whole or not at all, through no link, and one from elsewhere is read up to a limit.

Logs and locks are the exception to *whole*: they are changed where they are.
"""

import errno
import json
import os
import re
import secrets
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, BinaryIO, Literal, TextIO

UNFINISHED = ".unfinished"  # ends the name of a file that is being written
LEFTOVER = re.compile(rf"[0-9a-f]{{16}}{re.escape(UNFINISHED)}")
MEGABYTE = 2**20
MOST_FOLDERS = 3000  # that are looked into for games
LARGEST_JSON = 64 * MEGABYTE  # in memory it takes ten to thirty times as much
LONGEST_LINE = MEGABYTE
HALF_CHARACTER = re.compile(
    rb"\\u[dD][89a-fA-F]"
)  # of two that are one character; without the other it is none


@contextmanager
def written_whole(path: Path) -> Iterator[BinaryIO]:
    """Yields a file that takes the name `path` once the block has ended; an exception leaves what was there.

    It is written under a random name beside `path`, which must not exist yet and is no link, and flushed to the disk. It gets the
    permissions of the file that it replaces; a new one gets those of the umask. A link at `path` is replaced, never followed.
    What a killed process has left unfinished in the folder is removed.

    Raises:
      OSError: with the name of the file.
    """
    kept = _permissions(path)
    _remove_leftovers(path.parent)
    with naming(path), _open_unfinished(path, kept) as file:
        unfinished = Path(file.name)
        try:
            if kept is not None and hasattr(os, "fchmod"):
                os.fchmod(file.fileno(), kept)  # of which the umask has perhaps taken some
            yield file
            file.flush()
            os.fsync(file.fileno())
            os.replace(unfinished, path)
        except BaseException as error:
            _name_instead(error, unfinished, path)
            with suppress(OSError):
                unfinished.unlink(missing_ok=True)
            raise


def write_whole(path: Path, content: bytes | str) -> None:
    """Writes a file whole or not at all, as `written_whole` does; text as UTF-8, its line ends as they are."""
    with written_whole(path) as file:
        file.write(content.encode() if isinstance(content, str) else content)


def open_in_place(path: Path, mode: Literal["a", "a+", "r+"], newline: str | None = None) -> TextIO:
    """Opens a file of text, UTF-8, that is changed where it is. Raises OSError, with a reason in words, where it is a link."""
    try:
        return open(
            path,
            mode,
            encoding="utf-8",
            newline=newline,
            opener=lambda name, flags: _create(name, flags, None),
        )
    except OSError as error:
        if error.errno == errno.ELOOP:
            raise OSError(
                errno.ELOOP, "it is a link, through which nothing is written; remove it", str(path)
            ) from None
        raise


def line_end(text: str) -> str:
    """Returns how most lines of a text end: `\\r\\n` or `\\n`."""
    of_windows = text.count("\r\n")
    return "\r\n" if of_windows > text.count("\n") - of_windows else "\n"


def read_bytes(path: Path, limit: int) -> bytes:
    """Returns the content of a file. Raises OSError, with a reason in words, where it is no file or has more than `limit` bytes."""
    with open_regular(path) as file:
        size = os.fstat(file.fileno()).st_size
        content = file.read(
            min(size, limit) + 1
        )  # for what is asked for, Python takes the memory at once
    if len(content) > limit:
        raise OSError(errno.EFBIG, f"it has more than {limit:,} bytes", str(path))
    return content


@contextmanager
def open_regular(path: Path) -> Iterator[BinaryIO]:
    """Opens a file for reading. Raises OSError, with a reason in words, where it is no file: a pipe would be waited for, a device never ends."""
    with open(path, "rb", opener=_open_at_once) as file:
        if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
            raise OSError(errno.EINVAL, "it isn't a regular file", str(path))
        yield file


def read_lines(path: Path, limit: int = LONGEST_LINE) -> Iterator[bytes]:
    """Yields the lines of a file with their ends, however many there are, but for one at the end that is cut off.

    Raises OSError as `read_bytes` does, with a limit for each line.
    """
    with open_regular(path) as file:
        while line := file.readline(limit + 1):
            if len(line) > limit:
                raise OSError(errno.EFBIG, f"it has a line of more than {limit:,} bytes", str(path))
            if line.endswith(b"\n"):
                yield line


def read_json(path: Path, limit: int = LARGEST_JSON) -> Any:
    """Returns what a file of JSON holds. Raises OSError as `read_bytes` does, and ValueError where it is not JSON."""
    return parse_json(read_bytes(path, limit))


def parse_json(content: bytes) -> Any:
    """Returns what JSON holds. Raises ValueError where it is none, is nested too deep to be read, or holds text that can't be written."""
    try:
        value = json.loads(content)
    except RecursionError:
        raise ValueError("it is nested too deep") from None
    if HALF_CHARACTER.search(content):
        json.dumps(value, ensure_ascii=False).encode()
    return value


@contextmanager
def naming(path: Path | str) -> Iterator[None]:
    """Has an OSError say which file could not be written: the system names none when a disk is full."""
    try:
        yield
    except OSError as error:
        if error.errno is not None:
            error.filename = error.filename or str(path)
        raise


def games_below(root: Path) -> Iterator[Path]:
    """Yields the games in a folder and those below it, nearer ones first.

    At most 3,000 folders are looked into, so that a search of somebody's home ends soon. Hidden ones, links to folders,
    packages of JavaScript, what Python keeps, and names that cannot be shown are left out.
    """
    waiting, looked = [root], 0
    while waiting and looked < MOST_FOLDERS:
        folder, looked = waiting.pop(0), looked + 1
        try:
            entries = sorted(os.scandir(folder), key=lambda entry: entry.name)
        except OSError:
            continue
        entries = [
            entry
            for entry in entries
            if entry.name.isprintable() and not entry.name.startswith(".")
        ]
        yield from (
            Path(entry.path) for entry in entries if entry.name.endswith(".sj") and entry.is_file()
        )
        inside = [
            entry
            for entry in entries
            if entry.is_dir(follow_symlinks=False)
            and entry.name not in ("node_modules", "__pycache__")
        ]
        waiting += [Path(entry.path) for entry in inside]


def _permissions(path: Path) -> int | None:
    """Returns who may read, write and run a file; None where there is none, or a link."""
    try:
        mode = path.lstat().st_mode
    except FileNotFoundError:
        return None
    return stat.S_IMODE(mode) & 0o777 if stat.S_ISREG(mode) else None


def _open_unfinished(path: Path, permissions: int | None) -> BinaryIO:
    """Opens a new file beside `path`, locked, so that no other process takes it for one that a killed process has left."""
    while True:
        unfinished = path.with_name(
            f"{secrets.token_hex(8)}{UNFINISHED}"
        )  # no longer for a long name
        try:
            file = open(  # noqa: SIM115 (the caller closes it)
                unfinished, "xb", opener=lambda name, flags: _create(name, flags, permissions)
            )
        except OSError as error:
            _name_instead(error, unfinished, path)
            raise
        _lock(file, wait=True)
        if unfinished.exists():
            return file
        file.close()  # it was removed before it was locked


def _remove_leftovers(folder: Path) -> None:
    """Removes the unfinished files of processes that were killed: those that no process has locked."""
    with suppress(OSError):
        for name in filter(LEFTOVER.fullmatch, os.listdir(folder)):
            path = folder / name
            with suppress(OSError), open(path, "rb", opener=_open_at_once) as file:
                if _lock(file, wait=False):
                    path.unlink()


def _lock(file: BinaryIO, wait: bool) -> bool:
    """Locks an open file until it is closed, or its process ends; returns whether it could. `wait`: while another process locks it."""
    try:
        import fcntl
    except ImportError:  # a browser has none
        return False
    try:
        fcntl.flock(file, fcntl.LOCK_EX if wait else fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return False
    return True


def _name_instead(error: BaseException, unfinished: Path, path: Path) -> None:
    """Has an error name the file that was to be written."""
    if isinstance(error, OSError) and error.filename == str(unfinished):
        error.filename, error.filename2 = str(path), None


def _open_at_once(name: str, flags: int) -> int:
    """Opens a file; of a pipe, doesn't wait for whoever writes to it."""
    return os.open(name, flags | getattr(os, "O_NONBLOCK", 0))


def _create(name: str, flags: int, permissions: int | None) -> int:
    return os.open(
        name, flags | getattr(os, "O_NOFOLLOW", 0), 0o666 if permissions is None else permissions
    )

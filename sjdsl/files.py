"""Finds, reads and writes files.

A file is written whole or not at all, except logs and locks, and never through a link. A file of
somebody else is read up to a limit.
"""

import errno
import json
import os
import re
import secrets
import stat
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, BinaryIO, Literal, TextIO

UNFINISHED = ".unfinished"  # end of the name of a file that is being written
LEFTOVER = re.compile(rf"[0-9a-f]{{16}}{re.escape(UNFINISHED)}")
MEGABYTE = 2**20
MOST_FOLDERS = 3000  # that are searched for games
LARGEST_JSON = 64 * MEGABYTE  # in memory it takes ten to thirty times as much
LONGEST_LINE = MEGABYTE
SURROGATE = re.compile(rb"\\u[dD][89a-fA-F]")  # half a character, invalid without the other half


@contextmanager
def written_whole(path: Path) -> Iterator[BinaryIO]:
    """Yields a file that replaces `path` when the block ends; after an exception, nothing changes.

    It is written under a random name beside `path`, as a new file that is no link, and flushed to
    the disk. It gets the permissions of the file that it replaces; a new one gets those of the
    umask. A link at `path` is replaced, not followed. Unfinished files of killed processes in the
    folder are removed.

    Raises:
      OSError: with the name of the file.
    """
    permissions = _permissions(path)
    _remove_leftovers(path.parent)
    with naming(path), _open_unfinished(path, permissions) as file:
        unfinished = Path(file.name)
        try:
            if permissions is not None and hasattr(os, "fchmod"):
                os.fchmod(file.fileno(), permissions)  # the umask may have removed some
            yield file
            file.flush()
            os.fsync(file.fileno())
            os.replace(unfinished, path)
        except BaseException as error:
            _replace_name(error, unfinished, path)
            with suppress(OSError):
                unfinished.unlink(missing_ok=True)
            raise


def write_whole(path: Path, content: bytes | str) -> None:
    """Writes a file as `written_whole` does; text as UTF-8, without changing its line ends."""
    with written_whole(path) as file:
        file.write(content.encode() if isinstance(content, str) else content)


def open_in_place(path: Path, mode: Literal["a", "a+", "r+"]) -> TextIO:
    """Opens a text file in UTF-8 to change it in place.

    Raises:
      OSError: it is a link.
    """
    try:
        return open(
            path,
            mode,
            encoding="utf-8",
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
    num_windows = text.count("\r\n")
    num_unix = text.count("\n") - num_windows
    return "\r\n" if num_windows > num_unix else "\n"


def read_bytes(path: Path, limit: int) -> bytes:
    """Returns the content of a file.

    Raises:
      OSError: it isn't a regular file, or has more than `limit` bytes.
    """
    with open_regular(path) as file:
        size = os.fstat(file.fileno()).st_size
        content = file.read(min(size, limit) + 1)  # `read` allocates as much as it may return
    if len(content) > limit:
        raise OSError(errno.EFBIG, f"it has more than {limit:,} bytes", str(path))
    return content


@contextmanager
def open_regular(path: Path) -> Iterator[BinaryIO]:
    """Opens a regular file for reading.

    Raises:
      OSError: it is something else, such as a pipe or a device, from which reading might never end.
    """
    with open(path, "rb", opener=_open_without_waiting) as file:
        if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
            raise OSError(errno.EINVAL, "it isn't a regular file", str(path))
        yield file


def read_lines(path: Path) -> Iterator[bytes]:
    """Yields the lines of a file with their ends; a last line without an end is left out.

    Raises:
      OSError: it isn't a regular file, or has a line of more than `LONGEST_LINE` bytes.
    """
    with open_regular(path) as file:
        while line := file.readline(LONGEST_LINE + 1):
            if len(line) > LONGEST_LINE:
                problem = f"it has a line of more than {LONGEST_LINE:,} bytes"
                raise OSError(errno.EFBIG, problem, str(path))
            if line.endswith(b"\n"):
                yield line


def read_json(path: Path) -> Any:
    """Returns the value of a JSON file; raises the errors of `read_bytes` and `parse_json`."""
    return parse_json(read_bytes(path, LARGEST_JSON))


def parse_json(content: bytes) -> Any:
    """Returns the value of JSON.

    Raises:
      ValueError: it isn't JSON, is nested too deeply, or has text that can't be written.
    """
    try:
        value = json.loads(content)
    except RecursionError:
        raise ValueError("it is nested too deep") from None
    if SURROGATE.search(content):
        json.dumps(value, ensure_ascii=False).encode()
    return value


@contextmanager
def naming(path: Path | str) -> Iterator[None]:
    """Adds the name of the file to an OSError that has none, such as that of a full disk."""
    try:
        yield
    except OSError as error:
        if error.errno is not None:
            error.filename = error.filename or str(path)
        raise


def games_below(root: Path) -> Iterator[Path]:
    """Yields the games in a folder and those below it, nearer ones first.

    At most 3,000 folders are searched, so that a search of somebody's home ends soon. Hidden files,
    links to folders, JavaScript packages, Python's caches and names that can't be printed are left
    out.
    """
    waiting = deque([root])
    for _ in range(MOST_FOLDERS):
        if not waiting:
            return
        try:
            entries = sorted(os.scandir(waiting.popleft()), key=lambda entry: entry.name)
        except OSError:
            continue
        for entry in entries:
            if not entry.name.isprintable() or entry.name.startswith("."):
                continue
            if entry.name.endswith(".sj") and entry.is_file():
                yield Path(entry.path)
            is_package = entry.name in ("node_modules", "__pycache__")
            if entry.is_dir(follow_symlinks=False) and not is_package:
                waiting.append(Path(entry.path))


def _permissions(path: Path) -> int | None:
    """Returns the permissions of a file, None if there is none or it is a link."""
    try:
        mode = path.lstat().st_mode
    except FileNotFoundError:
        return None
    return stat.S_IMODE(mode) & 0o777 if stat.S_ISREG(mode) else None


def _open_unfinished(path: Path, permissions: int | None) -> BinaryIO:
    """Opens a new file beside `path`, locked so that no other process takes it for a leftover."""
    while True:
        unfinished = path.with_name(f"{secrets.token_hex(8)}{UNFINISHED}")  # of limited length
        try:
            file = open(  # noqa: SIM115 (the caller closes it)
                unfinished, "xb", opener=lambda name, flags: _create(name, flags, permissions)
            )
        except OSError as error:
            _replace_name(error, unfinished, path)
            raise
        _lock(file, wait=True)
        if unfinished.exists():
            return file
        file.close()  # it was removed before it was locked


def _remove_leftovers(folder: Path) -> None:
    """Removes the unfinished files of killed processes, which no process has locked."""
    with suppress(OSError):
        for name in filter(LEFTOVER.fullmatch, os.listdir(folder)):
            path = folder / name
            with suppress(OSError), open(path, "rb", opener=_open_without_waiting) as file:
                if _lock(file, wait=False):
                    path.unlink()


def _lock(file: BinaryIO, wait: bool) -> bool:
    """Locks an open file until it is closed or its process ends; returns whether this succeeded.

    Args:
      wait: whether to wait for another process that has locked it.
    """
    try:
        import fcntl
    except ImportError:  # a browser has none
        return False
    try:
        fcntl.flock(file, fcntl.LOCK_EX if wait else fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return False
    return True


def _replace_name(error: BaseException, unfinished: Path, path: Path) -> None:
    """Makes an error name `path`, not the unfinished file."""
    if isinstance(error, OSError) and error.filename == str(unfinished):
        error.filename = str(path)
        error.filename2 = None


def _open_without_waiting(name: str, flags: int) -> int:
    """Opens a file, without waiting for whoever writes to it if it is a pipe."""
    return os.open(name, flags | getattr(os, "O_NONBLOCK", 0))


def _create(name: str, flags: int, permissions: int | None) -> int:
    """Opens a file that may be new and is no link."""
    flags |= getattr(os, "O_NOFOLLOW", 0)
    return os.open(name, flags, 0o666 if permissions is None else permissions)

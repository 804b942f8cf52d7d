"""The lock of a run's folder: only one process writes there. The system releases it however the process ends."""

import os
import socket
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from filelock import FileLock, Timeout

from sjdsl.files import open_in_place

from .run_errors import RunError

LOCK = ".lock"  # in the folder while a process trains there, and after one that was killed


def is_unused(run_dir: Path) -> bool:
    """Whether a run may start in a folder: it is missing, or empty but for the lock of a run that never started."""
    if not run_dir.exists():
        return True
    return run_dir.is_dir() and all(path.name == LOCK for path in run_dir.iterdir())


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Locks the folder of a run, which is made if it is missing.

    Raises:
      RunError: another process trains there. OSError: the lock is a link.
    """
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / LOCK
    try:
        lock = FileLock(path).acquire(timeout=0)
    except Timeout:
        raise RunError(
            f"{folder} is in use: {_holder(path)} trains there. Wait until it has ended, or name another folder"
        ) from None
    with lock:
        _name_holder(path)
        try:
            yield
        finally:
            # While it is held: one who opens it only now finds that it is gone, and makes another.
            path.unlink(missing_ok=True)


def _holder(path: Path) -> str:
    """Returns which process holds a lock, by what it wrote there; the file may just have gone."""
    with suppress(FileNotFoundError):
        return path.read_text("utf-8").strip() or "another process"
    return "another process"


def _name_holder(path: Path) -> None:
    """Writes into the lock which process holds it, for the message to others; a full disk is no error."""
    with suppress(OSError), open_in_place(path, "r+") as file:
        file.truncate(0)
        file.write(f"process {os.getpid()} on {socket.gethostname()}")

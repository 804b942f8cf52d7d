"""The lock of a cell: of several processes one runs it. The system takes the lock back when the process ends, however that is."""

from pathlib import Path

from filelock import FileLock, Timeout

LOCKS = "locks"  # folder of a sweep
PATIENCE = 1.0  # seconds: a process that only looks whether a cell is run holds its lock for far less


def take(sweep: Path, name: str) -> FileLock | None:
    """Returns the lock of a cell, to be released; None where another process has it."""
    (sweep / LOCKS).mkdir(exist_ok=True)
    lock = FileLock(_path(sweep, name))
    try:
        lock.acquire(timeout=PATIENCE)
    except Timeout:
        return None
    return lock


def is_running(sweep: Path, name: str) -> bool:
    """Whether a process, perhaps this one, runs a cell."""
    if not _path(sweep, name).exists():
        return False
    lock = FileLock(_path(sweep, name))
    try:
        with lock.acquire(timeout=0):
            return False
    except Timeout:
        return True


def _path(sweep: Path, name: str) -> Path:
    return sweep / LOCKS / f"{name}.lock"

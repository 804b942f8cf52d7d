"""The lock of a cell: only one process runs it. The system releases the lock however the process
ends.
"""

from pathlib import Path

from filelock import FileLock, Timeout

LOCKS = "locks"  # folder of a sweep
# Seconds. A process that only checks whether a cell is running holds its lock for far less.
PATIENCE = 1.0


def take_lock(sweep: Path, name: str) -> FileLock | None:
    """Takes the lock of a cell and returns it, for the caller to release; None if another process
    has it.
    """
    (sweep / LOCKS).mkdir(exist_ok=True)
    lock = FileLock(_lock_path(sweep, name))
    try:
        lock.acquire(timeout=PATIENCE)
    except Timeout:
        return None
    return lock


def is_running(sweep: Path, name: str) -> bool:
    """Whether a process (perhaps this one) is running a cell."""
    if not _lock_path(sweep, name).exists():
        return False
    lock = FileLock(_lock_path(sweep, name))
    try:
        with lock.acquire(timeout=0):
            return False
    except Timeout:
        return True


def _lock_path(sweep: Path, name: str) -> Path:
    return sweep / LOCKS / f"{name}.lock"

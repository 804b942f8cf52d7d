"""The lock of a run's folder: only one process writes there. The system releases it however the process ends."""

import fcntl
import os
import socket
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from sjdsl.files import open_in_place

from .run_errors import RunError

LOCK = ".lock"  # stays in the folder: a lock is held by a process, not by the file


def is_unused(run_dir: Path) -> bool:
    """Whether a run may start in a folder: it is missing, or empty but for the lock of a run that never started."""
    return not run_dir.exists() or (
        run_dir.is_dir() and all(path.name == LOCK for path in run_dir.iterdir())
    )


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Locks the folder of a run, which is made if it is missing.

    Raises:
      RunError: another process trains there. OSError: the lock is a link.
    """
    folder.mkdir(parents=True, exist_ok=True)
    with open_in_place(folder / LOCK, "a+") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            file.seek(0)
            holder = file.read().strip() or "another process"
            raise RunError(
                f"{folder} is in use: {holder} trains there. Wait until it has ended, or name another folder"
            ) from None
        except OSError as error:
            warnings.warn(
                f"{folder} can't be locked ({error.strerror}): make sure that no other process writes there",
                stacklevel=3,
            )
        with suppress(OSError):  # the holder only matters to the message above
            file.truncate(0)
            file.write(f"process {os.getpid()} on {socket.gethostname()}")
            file.flush()
        yield

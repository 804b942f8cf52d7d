"""SIGTERM, which clusters, containers and `timeout` send, ends work as Ctrl-C does: what was done is kept."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

TERMINATED = 128 + signal.SIGTERM  # the exit status of a process that SIGTERM ended


class Terminated(SystemExit, KeyboardInterrupt):
    """SIGTERM, for whatever handles Ctrl-C; where nothing does, Python exits with its status and prints no traceback."""

    def __init__(self) -> None:
        super().__init__(TERMINATED)


@contextmanager
def raising_on_sigterm() -> Iterator[None]:
    """Makes SIGTERM raise `Terminated` in the main thread until the block ends.

    Off the main thread, and where the process ignores or handles it already, nothing changes.
    """
    if (
        threading.current_thread() is not threading.main_thread()
        or signal.getsignal(signal.SIGTERM) is not signal.SIG_DFL
    ):
        yield
        return
    signal.signal(signal.SIGTERM, _terminate)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, signal.SIG_DFL)


def sigterm_raises() -> bool:
    """Whether SIGTERM raises `Terminated` at present."""
    return signal.getsignal(signal.SIGTERM) is _terminate


def _terminate(number: int, frame: FrameType | None) -> None:
    del number, frame
    signal.signal(
        signal.SIGTERM, signal.SIG_IGN
    )  # `timeout` sends it to the process, then to its group
    raise Terminated

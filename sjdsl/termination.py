"""SIGTERM, which clusters, containers and `timeout` send, ends work as Ctrl-C does."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

TERMINATED = 128 + signal.SIGTERM  # the exit status of a process that SIGTERM ended


class Terminated(SystemExit, KeyboardInterrupt):
    """SIGTERM, as an exception. Code that handles Ctrl-C handles it; else Python exits quietly."""

    def __init__(self) -> None:
        super().__init__(TERMINATED)


@contextmanager
def raising_on_sigterm() -> Iterator[None]:
    """Makes SIGTERM raise `Terminated` in the main thread until the block ends.

    In another thread, and if the process ignores or handles it already, nothing changes.
    """
    is_main_thread = threading.current_thread() is threading.main_thread()
    if not is_main_thread or signal.getsignal(signal.SIGTERM) is not signal.SIG_DFL:
        yield
        return
    signal.signal(signal.SIGTERM, _terminate)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, signal.SIG_DFL)


def sigterm_raises() -> bool:
    """Returns whether SIGTERM raises `Terminated` now."""
    return signal.getsignal(signal.SIGTERM) is _terminate


def _terminate(number: int, frame: FrameType | None) -> None:
    del number, frame
    # `timeout` sends it twice, to the process and to its group.
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    raise Terminated

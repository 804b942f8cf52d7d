"""Checks that a command has a terminal, and opens a screen in it."""

import os
import sys
import threading
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from sjdsl.extras import require
from sjdsl.screen import COMPILING

if TYPE_CHECKING:
    from sjdsl.compiler import ir
    from sjdsl.screen.session import Session


def can_show_screen() -> bool:
    """Returns whether keys can be read and a screen drawn: textual reads standard input and draws on standard error."""
    return sys.stdin.isatty() and sys.stderr.isatty() and os.environ.get("TERM", "") not in ("", "dumb")


INTERRUPTED = 130  # the exit status of a command that Ctrl-C ended


def leave_at_once_if_compiling(status: int) -> None:
    """Ends the process at once if XLA may still be at work: it can't be stopped, and crashes when Python ends.

    That is after Ctrl-C, which may come at any time, and while a game is being compiled for a screen that has closed. Whatever a command
    closes at its end is closed before.
    """
    if status == INTERRUPTED or any(thread.name == COMPILING for thread in threading.enumerate()):
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(status)


def run_screen(game: "ir.Game", session: "Session", compiled: Callable[[], Any], speed: float, waits: bool) -> None:
    """Shows a session and plays it until the person leaves; arguments are those of `sjdsl.screen.app.Screen`.

    Raises what went wrong while compiling.
    """
    require("screen", "textual")
    from sjdsl.screen.app import Screen

    screen = Screen(game, session, compiled, speed, waits)
    screen.run(mouse=False)
    if screen.fault is not None:
        raise screen.fault

"""Prints a last line that points to `sjdsl explain` for the codes in a command's messages."""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager

import click

_printed: list[tuple[str, bool]] = []  # the code of each message, and whether it went to stderr


def remember(codes: Iterable[str], err: bool) -> None:
    """Notes that messages with these codes were printed."""
    _printed.extend((code, err) for code in codes)


@contextmanager
def pointed() -> Iterator[None]:
    """Prints, after everything else, which command explains the first message."""
    _printed.clear()
    try:
        yield
    finally:
        if _printed:
            code, err = _printed[0]
            click.echo(
                f"`sjdsl explain {code}` says more about {'this' if len(_printed) == 1 else 'the first'} message.",
                err=err,
            )

"""Prints a last line that points to `sjdsl explain` for the code of a command's first message."""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager

import click

_printed: list[tuple[str, bool]] = []  # the code of each message, and whether it went to stderr


def add_codes(codes: Iterable[str], err: bool) -> None:
    """Notes that messages with these codes were printed, to standard error if `err`."""
    _printed.extend((code, err) for code in codes)


@contextmanager
def pointing_to_explanations() -> Iterator[None]:
    """Prints, after everything else, which command explains the first message."""
    _printed.clear()
    try:
        yield
    finally:
        if _printed:
            code, err = _printed[0]
            which = "this" if len(_printed) == 1 else "the first"
            click.echo(f"`sjdsl explain {code}` says more about {which} message.", err=err)

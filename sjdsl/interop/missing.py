"""The message that a library an adapter needs is not installed."""

from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def needs(extra: str) -> Iterator[None]:
    """Turns a failed import of the block into one line that says what to install.

    Args:
      extra: of the package `sjdsl`.
    Raises:
      ModuleNotFoundError: with that line.
    """
    try:
        yield
    except ModuleNotFoundError as error:
        raise ModuleNotFoundError(f"the package {error.name} is needed: pip install 'sjdsl[{extra}]'", name=error.name) from None

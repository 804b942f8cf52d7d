"""Optional packages: the error for a missing one names the extra that installs it."""

from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec


class MissingExtra(ModuleNotFoundError):
    """A feature needs packages of an extra, such as `sjdsl[pictures]`, that isn't installed."""

    def __init__(self, module: str | None, extra: str) -> None:
        super().__init__(
            f"the package {module} is needed: pip install 'sjdsl[{extra}]'", name=module
        )


def require(extra: str, *modules: str) -> None:
    """Raises MissingExtra if a module of an extra isn't installed, before work is lost."""
    for module in modules:
        if not is_installed(module):
            raise MissingExtra(module, extra)


def is_installed(module: str) -> bool:
    """Returns whether a module can be imported, without importing it."""
    return find_spec(module) is not None


@contextmanager
def needs(extra: str) -> Iterator[None]:
    """Turns a failed import of the block into MissingExtra."""
    try:
        yield
    except ModuleNotFoundError as error:
        raise MissingExtra(error.name, extra) from None

"""Copies of adapters, by `copy` and by `pickle`: created with the same arguments, and with the same state."""

from typing import Any, ClassVar, Self


class Copied:
    """An adapter that can be copied and pickled, although its compiled functions can't.

    Attributes:
      KEPT: the names of the attributes that hold its state.
    """

    KEPT: ClassVar[tuple[str, ...]] = ()
    _made_with: tuple[tuple[Any, ...], dict[str, Any]]

    def __new__(cls, *args: Any, **arguments: Any) -> Self:
        """Stores the arguments."""
        made = super().__new__(cls)
        made._made_with = args, arguments
        return made

    def __reduce__(self) -> tuple[Any, ...]:
        return (
            _remake,
            (type(self), *self._made_with),
            {name: vars(self)[name] for name in self.KEPT},
        )


def _remake(adapter: Any, args: tuple[Any, ...], arguments: dict[str, Any]) -> Any:
    return adapter(*args, **arguments)

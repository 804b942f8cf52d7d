"""Copies of adapters, by `copy` and by `pickle`: made with the same arguments, and standing where the first stood."""

from typing import Any, ClassVar, Self


class Copied:
    """An adapter that may be copied and pickled, though its compiled functions may not.

    Attributes:
      KEPT: names of the attributes that say where it stands.
    """

    KEPT: ClassVar[tuple[str, ...]] = ()
    _made_with: tuple[tuple[Any, ...], dict[str, Any]]

    def __new__(cls, *args: Any, **arguments: Any) -> Self:
        """Notes what it is made with."""
        made = super().__new__(cls)
        made._made_with = args, arguments
        return made

    def __reduce__(self) -> tuple[Any, ...]:
        return _made_again, (type(self), *self._made_with), {name: vars(self)[name] for name in self.KEPT}


def _made_again(adapter: Any, args: tuple[Any, ...], arguments: dict[str, Any]) -> Any:
    return adapter(*args, **arguments)

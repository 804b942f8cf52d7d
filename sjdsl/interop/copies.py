"""Copies of adapters, by `copy` and by `pickle`.

Created with the same arguments, and with the same state.
"""

from typing import Any, ClassVar, Self


class Copied:
    """An adapter that can be copied and pickled, although its compiled functions can't.

    Attributes:
      KEPT: the names of the attributes that hold its state.
    """

    KEPT: ClassVar[tuple[str, ...]] = ()
    _init_arguments: tuple[tuple[Any, ...], dict[str, Any]]

    def __new__(cls, *args: Any, **kwargs: Any) -> Self:
        """Stores the arguments."""
        adapter = super().__new__(cls)
        adapter._init_arguments = args, kwargs
        return adapter

    def __reduce__(self) -> tuple[Any, ...]:
        """Returns how to create a copy: with the same arguments, then with the same state."""
        state = {name: vars(self)[name] for name in self.KEPT}
        return _create, (type(self), *self._init_arguments), state


def _create(adapter: Any, args: tuple[Any, ...], kwargs: dict[str, Any]) -> Any:
    return adapter(*args, **kwargs)

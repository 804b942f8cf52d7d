"""What all nodes of the tree as written are: frozen dataclasses, equal by content."""

from dataclasses import FrozenInstanceError, dataclass
from typing import Any, dataclass_transform


@dataclass_transform(frozen_default=True)
class Node:
    """A subclass declares its fields and is a dataclass.

    `dataclass(frozen=True)` would compile six methods for each of the 89 classes, in every process that reads a game; here it compiles
    the one that makes a node, the others are the same for all.
    """

    def __init_subclass__(cls) -> None:
        cls.__doc__ = cls.__doc__ or cls.__name__  # else each is given its signature as text, slowly
        dataclass(eq=False, repr=False)(cls)

    def __setattr__(self, name: str, value: Any) -> None:
        if name in self.__dict__:
            raise FrozenInstanceError(f"cannot assign to field {name!r}")
        self.__dict__[name] = value

    def __delattr__(self, name: str) -> None:
        raise FrozenInstanceError(f"cannot delete field {name!r}")

    def __eq__(self, other: object) -> bool:
        return self.__dict__ == other.__dict__ if type(other) is type(self) else NotImplemented

    def __hash__(self) -> int:
        return hash((type(self), *self.__dict__.values()))

    def __repr__(self) -> str:
        return f"{type(self).__name__}({', '.join(f'{name}={value!r}' for name, value in self.__dict__.items())})"

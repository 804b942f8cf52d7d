"""Frozen classes, equal by content and cheap to declare, for AST nodes and diagnostics."""

from dataclasses import FrozenInstanceError, dataclass
from typing import Any, dataclass_transform


class Frozen:
    """`dataclass(frozen=True)` would compile six methods for each class, in every process that reads a game; these are the same for all."""

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


@dataclass_transform(frozen_default=True)
class Record(Frozen):
    """A subclass declares its fields and is a dataclass; only the method that makes one is compiled for each."""

    def __init_subclass__(cls) -> None:
        cls.__doc__ = cls.__doc__ or cls.__name__  # else each is given its signature as text, slowly
        dataclass(eq=False, repr=False)(cls)

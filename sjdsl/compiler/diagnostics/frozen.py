"""Frozen classes, equal by content and cheap to declare, for nodes, diagnostics and what the stages pass on."""

from collections.abc import Callable
from dataclasses import MISSING, Field, FrozenInstanceError, dataclass, field, fields
from typing import Any, ClassVar, dataclass_transform


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


@dataclass_transform(frozen_default=True, field_specifiers=(field,))
class Record(Frozen):
    """A subclass declares its fields and is a dataclass, without any method compiled for it."""

    __dataclass_fields__: ClassVar[dict[str, Field[Any]]]
    _names: ClassVar[tuple[str, ...]] = ()
    _defaults: ClassVar[dict[str, Any]] = {}
    _factories: ClassVar[dict[str, Callable[[], Any]]] = {}

    def __init_subclass__(cls, eq: bool = True) -> None:
        if not eq:  # each equals itself only
            cls.__eq__, cls.__hash__ = object.__eq__, object.__hash__  # type: ignore[method-assign]
        cls.__doc__ = (
            cls.__doc__ or cls.__name__
        )  # else each is given its signature as text, slowly
        dataclass(init=False, eq=False, repr=False)(cls)
        declared = fields(cls)
        cls._names = tuple(f.name for f in declared)
        cls._defaults = {f.name: f.default for f in declared if f.default is not MISSING}
        cls._factories = {
            f.name: f.default_factory for f in declared if f.default_factory is not MISSING
        }

    def __init__(self, *values: Any, **named: Any) -> None:
        names = self._names
        if named or len(values) != len(names):
            values = self._completed(values, named)
        self.__dict__.update(zip(names, values, strict=True))

    def _completed(self, values: tuple[Any, ...], named: dict[str, Any]) -> tuple[Any, ...]:
        """Returns a value for each field: those given in order, those given by name, and defaults."""
        names = self._names
        given = self._defaults | dict(zip(names, values, strict=False)) | named
        for name in self._factories.keys() - given:
            given[name] = self._factories[name]()
        twice = values and not named.keys().isdisjoint(names[: len(values)])
        if len(values) > len(names) or twice or given.keys() != set(names):
            raise TypeError(
                f"{type(self).__name__} takes {', '.join(names)}; given: {len(values)} values, and by name: {', '.join(named)}"
            )
        return tuple(given[name] for name in names)

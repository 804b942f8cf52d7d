"""Frozen classes, equal by content and cheap to declare: nodes, diagnostics, results of stages."""

from collections.abc import Callable
from dataclasses import MISSING, Field, FrozenInstanceError, dataclass, field, fields
from typing import Any, ClassVar, dataclass_transform


@dataclass_transform(frozen_default=True, field_specifiers=(field,))
class Record:
    """A frozen dataclass: a subclass declares its fields, and its methods are those of this class.

    `dataclass(frozen=True)` would compile six methods for each, in every process that reads a game.
    """

    __dataclass_fields__: ClassVar[dict[str, Field[Any]]]
    _names: ClassVar[tuple[str, ...]] = ()
    _defaults: ClassVar[dict[str, Any]] = {}
    _factories: ClassVar[dict[str, Callable[[], Any]]] = {}

    def __init_subclass__(cls, eq: bool = True) -> None:
        if not eq:  # each equals itself only
            cls.__eq__ = object.__eq__  # type: ignore[method-assign]
            cls.__hash__ = object.__hash__  # type: ignore[method-assign]
        if not cls.__doc__:  # else `dataclass` writes its signature there, slowly
            cls.__doc__ = cls.__name__
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
        """Returns a value for each field: those in order, those by name, and defaults."""
        names = self._names
        in_order = dict(zip(names, values, strict=False))
        by_name = self._defaults | in_order | named
        for name in self._factories.keys() - by_name:
            by_name[name] = self._factories[name]()
        if len(values) > len(names) or by_name.keys() != set(names):
            raise TypeError(f"{type(self).__name__} takes {', '.join(names)}")
        return tuple(by_name[name] for name in names)

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
        values = ", ".join(f"{name}={value!r}" for name, value in self.__dict__.items())
        return f"{type(self).__name__}({values})"

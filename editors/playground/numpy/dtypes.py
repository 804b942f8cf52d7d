"""Types of the elements of arrays, and how a value becomes one."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from .float32 import float32


@dataclass(frozen=True)
class dtype:
    """A type of elements. kind: as NumPy has it; cast: makes a value one of this type."""

    name: str
    kind: str
    cast: Callable[[Any], Any]

    def __call__(self, value: Any) -> Any:
        return self.cast(value)


def _wrapping(bits: int, signed: bool) -> Callable[[Any], int]:
    size, half = 1 << bits, 1 << bits - 1

    def cast(value: Any) -> int:
        number = int(value) % size
        return number - size if signed and number >= half else number

    return cast


bool_ = dtype("bool", "b", bool)
uint8, uint16 = dtype("uint8", "u", _wrapping(8, False)), dtype("uint16", "u", _wrapping(16, False))
int32, int64 = dtype("int32", "i", _wrapping(32, True)), dtype("int64", "i", _wrapping(64, True))
float64 = dtype("float64", "f", float)
real32 = dtype("float32", "f", float32)
text = dtype("str", "U", str)
object_ = dtype("object", "O", lambda value: value)
_BY_CLASS: dict[Any, dtype] = {
    bool: bool_,
    int: int64,
    float: float64,
    float32: real32,
    str: text,
    object: object_,
}


def dtype_of(asked: Any) -> dtype:
    """Returns the type that `asked` names: one of ours, or a class of Python."""
    return asked if isinstance(asked, dtype) else _BY_CLASS[asked]


def common(values: list[Any]) -> dtype:
    """Returns the type of an array of these values."""
    kinds = set(map(type, values))
    if not kinds:
        return float64
    if len(kinds) == 1:
        return _BY_CLASS.get(kinds.pop(), object_)
    if kinds <= {bool, int}:
        return int64
    if kinds <= {bool, int, float, float32}:
        return float64 if kinds != {float32} else real32
    return text if str in kinds else object_

"""Real numbers of 32 bits: a float that is rounded after every operation, as IEEE 754 asks and NumPy does.

The operations are done in 64 bits and rounded once more. For + - * / this gives the correctly rounded result: 53 bits are more than twice
24 and two (Figueroa, "When is double rounding innocuous?", 1995).
"""

import math
import struct
from collections.abc import Callable
from typing import Any

_FORMAT = struct.Struct(
    "<f"
)  # without "<", numbers that are too large become an infinity and nobody is told
_PACK, _UNPACK = _FORMAT.pack, _FORMAT.unpack
_RAISES: dict[str, bool] = {"over": False, "invalid": False}
_SMALLEST_NORMAL = 2.0**-126


class errstate:
    """Raises FloatingPointError inside where a result overflows, or is no number: `over="raise"`, `invalid="raise"`."""

    def __init__(self, **asked: str) -> None:
        self._asked = {name: how == "raise" for name, how in asked.items()}

    def __enter__(self) -> None:
        self._before = dict(_RAISES)
        _RAISES.update(self._asked)

    def __exit__(self, *_: object) -> None:
        _RAISES.update(self._before)


class floating(float):
    """What all reals of the stand-in are."""

    __slots__ = ()


def rounded(value: float) -> float:
    """Returns the nearest number of 32 bits; an infinity if it is too large."""
    try:
        return _UNPACK(_PACK(value))[0]  # type: ignore[no-any-return]
    except OverflowError:
        if _RAISES["over"]:
            raise FloatingPointError("overflow") from None
        return math.copysign(math.inf, value)


def _binary(name: str) -> Callable[[Any, Any], Any]:
    of_float = getattr(float, name)

    def operate(left: Any, right: Any) -> Any:
        if type(right) is not float32:
            if not isinstance(right, int | float):
                return NotImplemented
            right = rounded(right)
        return _result(of_float(left, right), left, right)

    return operate


def _result(value: float, *operands: float) -> "float32":
    if value != value and _RAISES["invalid"] and all(operand == operand for operand in operands):
        raise FloatingPointError("invalid value")
    if math.isinf(value) and _RAISES["over"] and all(map(math.isfinite, operands)):
        raise FloatingPointError("overflow")
    return float.__new__(float32, rounded(value))


def _division(left: Any, right: Any) -> Any:
    if not isinstance(right, int | float):
        return NotImplemented
    right = rounded(right)
    if right == 0:
        if left == 0 or left != left:
            return _result(math.nan, left)
        return float.__new__(float32, math.copysign(math.inf, left) * math.copysign(1.0, right))
    return _result(float(left) / right, left, right)


def _comparison(name: str) -> Callable[[Any, Any], Any]:
    of_float = getattr(float, name)

    def compare(left: Any, right: Any) -> Any:
        if type(right) is not float32:
            if not isinstance(right, int | float):
                return NotImplemented
            right = rounded(right)
        return of_float(left, right)

    return compare


class float32(floating):
    """A real of 32 bits. Numbers of Python beside it are rounded first."""

    __slots__ = ()

    def __new__(cls, value: Any = 0.0) -> "float32":
        return value if type(value) is cls else float.__new__(cls, rounded(float(value)))

    def item(self) -> float:
        return float(self)

    def __neg__(self) -> "float32":
        return float.__new__(float32, -float(self))

    def __abs__(self) -> "float32":
        return float.__new__(float32, abs(float(self)))

    def __truediv__(self, other: Any) -> Any:
        return _division(self, other)

    def __rtruediv__(self, other: Any) -> Any:
        return _division(float32(other), self)

    def __float__(self) -> float:
        return float.__pos__(self)

    def __str__(self) -> str:
        """Returns the shortest decimal that is nearest to this number of 32 bits."""
        plain = float.__pos__(self)
        if plain == 0 or not math.isfinite(plain):
            return repr(plain)
        short = next(
            text
            for digits in range(1, 18)
            if rounded(float(text := f"{plain:.{digits}g}")) == plain
        )
        return repr(float(short)) if abs(plain) < 1e16 else short

    def __repr__(self) -> str:
        return f"np.float32({self})"

    def __format__(self, spec: str) -> str:
        return format(float.__pos__(self), spec) if spec else str(self)

    def __reduce__(self) -> Any:
        return float32, (float(self),)

    __hash__ = float.__hash__


for _name in ("add", "sub", "mul", "mod"):
    setattr(float32, f"__{_name}__", _binary(f"__{_name}__"))
    setattr(float32, f"__r{_name}__", _binary(f"__r{_name}__"))
for _name in ("lt", "le", "gt", "ge", "eq", "ne"):
    setattr(float32, f"__{_name}__", _comparison(f"__{_name}__"))

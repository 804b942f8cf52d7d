"""The part of NumPy that the front end, the interpreter and the pictures use, in plain Python: for browsers, where NumPy cannot be had.

NumPy has no wheel for Pyodide on PyPI. `tests/playground` compares this with NumPy, function by function and game by game.
"""

import math
import operator
from collections.abc import Callable
from functools import reduce as _reduce
from typing import Any

from .array import apply, as_array, broadcast_to, joined_shape, ndarray
from .array import nonzero as _nonzero
from .dtypes import bool_, dtype, float64, int32, int64, uint8, uint16
from .float32 import errstate, float32, floating

__all__ = [
    "bool_",
    "broadcast_to",
    "dtype",
    "errstate",
    "float32",
    "float64",
    "floating",
    "int32",
    "int64",
    "ndarray",
    "uint8",
    "uint16",
]
__version__ = "0"


class ufunc:
    """A function of each element. `reduce`: joins the elements of an array along its first axis."""

    def __init__(self, fn: Callable[..., Any], type_: dtype | None = None) -> None:
        self._fn, self._type = fn, type_

    def __call__(self, *values: Any) -> Any:
        return apply(self._fn, *values, type_=self._type)

    def reduce(self, values: Any) -> Any:
        return _reduce(self, list(values))


less, less_equal, greater, greater_equal = (
    ufunc(fn, bool_) for fn in (operator.lt, operator.le, operator.gt, operator.ge)
)
equal, not_equal = ufunc(operator.eq, bool_), ufunc(operator.ne, bool_)
logical_not = ufunc(operator.not_, bool_)
logical_and, logical_or = (
    ufunc(lambda a, b: bool(a and b), bool_),
    ufunc(lambda a, b: bool(a or b), bool_),
)
isfinite = ufunc(math.isfinite, bool_)
minimum, maximum = ufunc(min), ufunc(max)
ceil = ufunc(lambda value: float(math.ceil(value)))
bitwise_count = ufunc(lambda value: abs(int(value)).bit_count(), uint8)
sign = ufunc(lambda value: (value > 0) - (value < 0))


def array(value: Any, type_: Any = None) -> ndarray:
    return as_array(value, type_).copy()


def asarray(value: Any, type_: Any = None) -> ndarray:
    return as_array(value, type_)


def full(shape: Any, value: Any, type_: Any = None) -> ndarray:
    sizes = (shape,) if isinstance(shape, int) else tuple(shape)
    filled = broadcast_to(value, sizes)
    return filled if type_ is None else filled.astype(type_)


def zeros(shape: Any, type_: Any = float) -> ndarray:
    return full(shape, 0, type_)


def ones(shape: Any, type_: Any = float) -> ndarray:
    return full(shape, 1, type_)


def zeros_like(of: ndarray) -> ndarray:
    return zeros(of.shape, of.dtype)


def arange(*limits: int) -> ndarray:
    numbers = list(range(*limits))
    return ndarray(numbers, (len(numbers),), int64)


def where(condition: Any, yes: Any, no: Any) -> Any:
    return apply(lambda c, y, n: y if c else n, condition, yes, no)


def clip(value: Any, low: Any, high: Any) -> Any:
    return apply(lambda v, least, most: min(max(v, least), most), value, low, high)


def isin(value: Any, words: Any) -> Any:
    known = set(as_array(words).flat)
    return apply(lambda v: v in known, value, type_=bool_)


def divmod(value: Any, by: Any) -> tuple[Any, Any]:
    return as_array(value) // by, as_array(value) % by


def any(value: Any) -> bool:
    return bool(as_array(value).any())


def argmin(value: Any) -> int:
    flat = as_array(value).flat
    return flat.index(min(flat))


def nonzero(value: Any) -> tuple[ndarray, ...]:
    return _nonzero(as_array(value))


def flatnonzero(value: Any) -> ndarray:
    return _nonzero(as_array(value).reshape(-1))[0]


def reshape(value: Any, shape: Any) -> ndarray:
    return as_array(value).reshape(shape)


def broadcast_arrays(*values: Any) -> tuple[ndarray, ...]:
    arrays = [as_array(value) for value in values]
    shape = joined_shape([a.shape for a in arrays])
    return tuple(broadcast_to(a, shape) for a in arrays)


def stack(arrays: Any, axis: int = 0) -> ndarray:
    parts = [as_array(part) for part in arrays]
    shape, type_ = (
        parts[0].shape,
        next((p.dtype for p in parts if p.dtype.kind != "b"), parts[0].dtype),
    )
    axis %= len(shape) + 1
    inner = math.prod(shape[axis:])
    flat = [
        v
        for o in range(math.prod(shape[:axis]))
        for p in parts
        for v in p.flat[o * inner : (o + 1) * inner]
    ]
    return ndarray([type_.cast(v) for v in flat], (*shape[:axis], len(parts), *shape[axis:]), type_)


def meshgrid(*axes: Any, indexing: str) -> tuple[ndarray, ...]:
    assert indexing == "ij"
    shape = tuple(len(axis) for axis in axes)
    places = [
        (1,) * number + (-1,) + (1,) * (len(axes) - number - 1) for number in range(len(axes))
    ]
    return tuple(broadcast_to(axis.reshape(place), shape) for axis, place in zip(axes, places))


def unique(
    value: Any, axis: int | None = None, return_counts: bool = False, return_inverse: bool = False
) -> Any:
    """Returns the different values in order; with `axis=0` the different rows."""
    given = as_array(value)
    entries = given.flat if axis is None else [tuple(row) for row in given.tolist()]
    found = sorted(set(entries))
    number = {entry: place for place, entry in enumerate(found)}
    shown = (
        as_array(found)
        if axis is None
        else ndarray([v for row in found for v in row], (len(found), *given.shape[1:]), given.dtype)
    )
    inverse = ndarray([number[entry] for entry in entries], (len(entries),), int64)
    if return_counts:
        counts = [0] * len(found)
        for place in inverse.flat:
            counts[place] += 1
        return shown, as_array(counts)
    return (shown, inverse) if return_inverse else shown

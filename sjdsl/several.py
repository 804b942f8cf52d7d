"""Arguments that take several values, or one."""

from collections.abc import Iterable, Mapping
from os import PathLike
from typing import Any


def several(values: Any) -> tuple[Any, ...]:
    """Returns values as a tuple, and one value, such as a text or a path, as a tuple of one."""
    is_one = isinstance(values, str | PathLike | Mapping) or not isinstance(values, Iterable)
    is_scalar = getattr(values, "ndim", 1) == 0  # an array
    return (values,) if is_one or is_scalar else tuple(values)

"""Arguments that take several values, or one."""

from collections.abc import Iterable, Mapping
from os import PathLike
from typing import Any


def several(values: Any) -> tuple[Any, ...]:
    """Returns values as a tuple; a single one, such as a text, a path, a number or a function, as a tuple of one."""
    is_one = isinstance(values, str | PathLike | Mapping) or not isinstance(values, Iterable)
    has_no_axis = getattr(values, "ndim", 1) == 0  # an array
    return (values,) if is_one or has_no_axis else tuple(values)

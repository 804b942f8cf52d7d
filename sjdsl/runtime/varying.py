"""Types of values that differ from device to device, which `jax.shard_map` keeps."""

from collections.abc import Callable
from typing import Any, TypeVar

import jax
from jax import Array, lax

T = TypeVar("T")


def settled(step: Callable[[T], T], start: T) -> T:
    """Returns the first values of a loop with the types that they have after an iteration.

    Inside `jax.shard_map` a constant has another type than what is computed from values that differ
    between devices, and a loop must not change types. Elsewhere `start` is returned unchanged.

    Args:
      step: one iteration of the loop.
    """
    if not jax.sharding.get_abstract_mesh().manual_axes:
        return start
    while True:
        after = jax.eval_shape(step, start)
        wider = jax.tree.map(_with_axes_of, start, after)
        pairs = zip(jax.tree.leaves(wider), jax.tree.leaves(start), strict=True)
        if all(new is old for new, old in pairs):
            return start
        start = wider


def either(test: Array, yes: Callable[[], T], no: Callable[[], T]) -> T:
    """Returns `lax.cond(test, yes, no)`, also inside `jax.shard_map` if one branch gives constants.

    Their types differ there from computed values.
    """
    if jax.sharding.get_abstract_mesh().manual_axes:
        types = jax.eval_shape(yes), jax.eval_shape(no)
        yes = _widened(yes, types)
        no = _widened(no, types)
    result: T = lax.cond(test, yes, no)
    return result


def _widened(branch: Callable[[], T], types: tuple[T, T]) -> Callable[[], T]:
    """Returns a branch whose values may differ between devices wherever those of a type may."""

    def widened() -> T:
        values = branch()
        for type_ in types:
            values = jax.tree.map(_with_axes_of, values, type_)
        return values

    return widened


def _axes(type_: Any) -> frozenset[str]:
    """Returns the device axes along which values of a type may differ."""
    manual = getattr(type_, "manual_axis_type", None)  # JAX 0.10
    axes: frozenset[str] = getattr(type_, "vma", frozenset()) if manual is None else manual.varying
    return axes


def _with_axes_of(value: Any, type_: Any) -> Any:
    """Returns a value as one that may differ wherever values of a type may."""
    missing = _axes(type_) - _axes(jax.typeof(value))
    return lax.pcast(value, tuple(missing), to="varying") if missing else value

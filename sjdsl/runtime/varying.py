"""Types of values that differ from device to device, which `jax.shard_map` keeps."""

from collections.abc import Callable
from typing import Any, TypeVar

import jax
from jax import Array, lax

T = TypeVar("T")


def settled(step: Callable[[T], T], start: T) -> T:
    """Returns the first values of a loop with the types that they have after a turn.

    Inside `jax.shard_map` a constant has another type than what is computed from values that differ between devices, and a loop must not
    change types. Elsewhere `start` is returned as it is.

    Args:
      step: one turn of the loop.
    """
    if not jax.sharding.get_abstract_mesh().manual_axes:
        return start
    while True:
        after = jax.eval_shape(step, start)
        wider = jax.tree.map(_with_axes_of, start, after)
        if all(
            one is other
            for one, other in zip(jax.tree.leaves(wider), jax.tree.leaves(start), strict=True)
        ):
            return start
        start = wider


def either(test: Array, yes: Callable[[], T], no: Callable[[], T]) -> T:
    """Returns `lax.cond(test, yes, no)` of branches of which one may give constants: inside `jax.shard_map` their types differ."""
    if jax.sharding.get_abstract_mesh().manual_axes:
        kinds = jax.eval_shape(yes), jax.eval_shape(no)
        yes, no = _of_both(yes, kinds), _of_both(no, kinds)
    result: T = lax.cond(test, yes, no)
    return result


def _of_both(branch: Callable[[], T], kinds: tuple[T, T]) -> Callable[[], T]:
    """Returns a branch whose values differ between devices wherever those of either branch do."""

    def widened() -> T:
        values = branch()
        for kind in kinds:
            values = jax.tree.map(_with_axes_of, values, kind)
        return values

    return widened


def _axes(kind: Any) -> frozenset[str]:
    """Returns the axes of devices along which values of a type differ."""
    now = getattr(kind, "manual_axis_type", None)  # JAX 0.10
    axes: frozenset[str] = getattr(kind, "vma", frozenset()) if now is None else now.varying
    return axes


def _with_axes_of(value: Any, kind: Any) -> Any:
    """Returns a value as one that differs wherever values of a type do."""
    missing = _axes(kind) - _axes(jax.typeof(value))
    return lax.pcast(value, tuple(missing), to="varying") if missing else value

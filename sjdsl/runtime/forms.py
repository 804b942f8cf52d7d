"""Kernels in two forms, one for CPUs and one for GPUs, that give the same bits: generated code says what is computed, and not how.

A CPU likes loops that end early and branches that are not taken; it computes what it has in its caches again and again. A GPU wants few
kernels, each of much independent work, and none that waits for the result of another (docs/performance.md, "Estimated by a model").
"""

from collections.abc import Callable
from functools import wraps
from typing import Any, TypeVar

import jax
from jax import lax

T = TypeVar("T")
forced = jax.make_user_context(
    None
)  # `with forced("gpu"):` and `with forced("cpu"):` choose the form, whatever the platform


def by_platform(cpu: Callable[..., T], gpu: Callable[..., T], *arguments: Any) -> T:
    """Returns what a kernel makes of its arguments, in the form for the platform that the program is compiled for.

    Where JAX has only CPUs the other form is not even traced. To compile for a GPU on such a machine, use `with forced("gpu"):`.
    """
    chosen = forced.value or ("cpu" if jax.default_backend() == "cpu" else None)
    if chosen is not None:
        return {"cpu": cpu, "gpu": gpu}[chosen](*arguments)
    result: T = lax.platform_dependent(
        *arguments, cpu=_all_in("cpu", cpu), default=_all_in("gpu", gpu)
    )
    return result


def in_one_form(function: Callable[..., T]) -> Callable[..., T]:
    """Returns a function that chooses the form once, for all kernels that it calls."""

    @wraps(function)
    def chosen(*arguments: Any, **named: Any) -> T:
        def called(arguments: Any, named: Any) -> T:
            return function(*arguments, **named)

        return by_platform(called, called, arguments, named)

    return chosen


def _all_in(form: str, kernel: Callable[..., Any]) -> Callable[..., Any]:
    """Returns a kernel in a form, with those that it calls."""

    def called(*arguments: Any) -> Any:
        with forced(form):
            return kernel(*arguments)

    return called

"""Kernels in two forms, for CPUs and for GPUs, with equal results.

Generated code determines what is computed, not how. On a CPU, loops that end early and branches
that aren't taken are cheap, and so is computing values in the cache again. A GPU is fast with few
kernels of much independent work, none of which waits for another (docs/research/performance.md,
"GPU model").
"""

from collections.abc import Callable
from functools import wraps
from typing import Any, TypeVar, cast

import jax
from jax import lax

T = TypeVar("T")
Kernel = TypeVar("Kernel", bound=Callable[..., Any])
# `with forced("gpu"):` and `with forced("cpu"):` choose the form, whatever the platform.
forced = jax.make_user_context(None)


def by_platform(cpu: Callable[..., T], gpu: Callable[..., T], *arguments: Any) -> T:
    """Returns the result of a kernel in the form for the platform of the compiled program.

    If JAX has only CPUs, the other form isn't traced. To compile for a GPU on such a machine, use
    `with forced("gpu"):`.
    """
    form = forced.value or ("cpu" if jax.default_backend() == "cpu" else None)
    if form is not None:
        return {"cpu": cpu, "gpu": gpu}[form](*arguments)
    result: T = lax.platform_dependent(
        *arguments, cpu=_in_form("cpu", cpu), default=_in_form("gpu", gpu)
    )
    return result


def one_function(kernel: Kernel, static: tuple[str, ...] = ()) -> Kernel:
    """Returns a kernel that is one function of the program for each shape, however often called.

    Args:
      static: names of its arguments that aren't arrays.
    """
    return cast(Kernel, jax.jit(kernel, static_argnames=static))


def in_one_form(function: Callable[..., T]) -> Callable[..., T]:
    """Returns a function that chooses the form once, for all kernels that it calls."""

    @wraps(function)
    def chosen(*arguments: Any, **named: Any) -> T:
        def called(arguments: Any, named: Any) -> T:
            return function(*arguments, **named)

        return by_platform(called, called, arguments, named)

    return chosen


def _in_form(form: str, kernel: Callable[..., Any]) -> Callable[..., Any]:
    """Returns a kernel that is traced in a form, with the kernels that it calls."""

    def traced(*arguments: Any) -> Any:
        with forced(form):
            return kernel(*arguments)

    return traced

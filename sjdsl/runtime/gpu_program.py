"""Rewrites a program for GPUs: small reductions and scatters, of which XLA makes kernels of their own, become part of what is around them.

What reads and writes arrays as JAX's authors mean it to is right for a CPU, where each of them is a loop. On a GPU it is one kernel more:

    any of four lanes   ->  any of five, the last of which is false: XLA puts it where it is asked for
    values.at[to].set   ->  each place compares itself with where each writer writes
    a sum of constants  ->  the constant it is, such as the bits of a set that has all members when an episode begins

The values are the same, bit for bit.
"""

import math
import operator
from collections.abc import Callable, Sequence
from functools import cache, partial, reduce, wraps
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array, lax
from jax.extend import core, source_info_util

from sjdsl.runtime.forms import by_platform
from sjdsl.runtime.packed_masks import PackedMasks

WARP = 32  # lanes of a GPU that work together: of a reduction of 2, 4, 8, 16 or 32 entries, or of more than 32, XLA makes a kernel
COMPUTED = {
    "and",
    "eq",
    "shift_right_logical",
}  # of constants while tracing: such as which of a block's two random numbers a draw is
MOST = 8192  # comparisons of a place with a writer up to which these cost less than a scatter


def in_its_form(function: Callable[..., Any]) -> Callable[..., Any]:
    """Returns a function of arrays that is the same on CPUs, and on GPUs rewritten; what it calls has the form for GPUs there, too."""

    @wraps(function)
    def chosen(*arguments: Any, **named: Any) -> Any:
        def as_written(arguments: Any, named: Any) -> Any:
            return function(*arguments, **named)

        return by_platform(as_written, rewritten(as_written), arguments, named)

    return chosen


def rewritten(function: Callable[..., Any]) -> Callable[..., Any]:
    """Returns a function of arrays, rewritten for GPUs."""

    def called(*arguments: Any) -> Any:
        leaves, tree = jax.tree.flatten(arguments)
        program, shapes = jax.make_jaxpr(
            lambda *flat: function(*jax.tree.unflatten(tree, flat)), return_shape=True
        )(*leaves)
        return jax.tree.unflatten(jax.tree.structure(shapes), _evaluated(program, leaves, {}))

    return called


def _evaluated(
    program: Any,
    arguments: Sequence[Any],
    functions: dict[Any, Any],
    constants: Sequence[Any] = (),
    masks: PackedMasks | None = None,
) -> list[Any]:
    """Returns what a program gives.

    Args:
      functions: those that programs call, rewritten once each for the constants they are given; XLA is given each once.
      constants: of the arguments, None for those that are none and for numbers: those of all streams of draws share a function.
      masks: what is known of those of the program that this one is a part of.
    """
    masks = masks or PackedMasks()
    values = dict(
        zip(
            [*program.jaxpr.constvars, *program.jaxpr.invars],
            [*program.consts, *arguments],
            strict=True,
        )
    )
    alike: dict[Any, Any] = {}  # arrays whose entries are all one scalar
    told = [
        *zip(program.jaxpr.constvars, program.consts, strict=True),
        *zip(program.jaxpr.invars, constants, strict=False),
    ]
    known = {
        of: partial(np.asarray, value) for of, value in told if _has_numbers(value)
    }  # constants, computed when they are asked for
    for equation in program.jaxpr.eqns:
        given = [of.val if isinstance(of, core.Literal) else values[of] for of in equation.invars]
        name, params = equation.primitive.name, equation.params
        constant = [
            partial(np.asarray, of.val) if isinstance(of, core.Literal) else known.get(of)
            for of in equation.invars
        ]
        if None not in constant:
            computed = cache(partial(_computed, equation, constant))
            known |= {
                of: partial(_output, computed, place) for place, of in enumerate(equation.outvars)
            }
            if name in IDENTITIES or name in COMPUTED:
                values |= zip(equation.outvars, computed(), strict=True)
                continue
        with source_info_util.user_context(equation.source_info.traceback):
            if name in ("jit", "pjit"):
                name, called = params["name"], params["jaxpr"]
                if name == "_where":  # in place, for what masks say of it
                    results = _evaluated(
                        called, given, functions, [each and each() for each in constant], masks
                    )
                elif name == "pack" and (words := masks.packed(given[0])) is not None:
                    results = [words]
                else:
                    arrays = [
                        each() if each and jnp.ndim(value) else None
                        for each, value in zip(constant, given, strict=True)
                    ]
                    results = _function(called, functions, arrays)(*given)
            elif name == "reduce_sum" and (number := masks.count(given[0])) is not None:
                results = [number]
            elif name in ("scatter", "scatter-add") and _is_comparable(params, *given):
                scalar = given[2] if jnp.ndim(given[2]) == 0 else alike.get(equation.invars[2])
                results = [_compared(name, params, scalar, *given)]
            else:
                given = _longer(name, params, given) if name in IDENTITIES else given
                results = equation.primitive.bind(*given, **params)
                results = results if equation.primitive.multiple_results else [results]
        masks.note(name, given, constant, results[0])
        if name == "broadcast_in_dim" and jnp.ndim(given[0]) == 0:
            alike[equation.outvars[0]] = given[0]
        values.update(zip(equation.outvars, results, strict=True))
    return [of.val if isinstance(of, core.Literal) else values[of] for of in program.jaxpr.outvars]


def _has_numbers(value: Any) -> bool:
    """Returns whether a constant of a program, or an argument, has numbers while tracing; a key has none that NumPy knows."""
    return (
        value is not None
        and not isinstance(value, jax.core.Tracer)
        and not jnp.issubdtype(value.dtype, jax.dtypes.extended)
    )


def _output(computed: Callable[[], list[Any]], place: int) -> Any:
    return computed()[place]


def _computed(equation: Any, constant: Sequence[Any]) -> list[Any]:
    """Returns what an equation makes of constants."""
    with jax.ensure_compile_time_eval():
        results = equation.primitive.bind(*(each() for each in constant), **equation.params)
        return list(map(np.asarray, results if equation.primitive.multiple_results else [results]))


def _function(program: Any, functions: dict[Any, Any], constants: Sequence[Any]) -> Any:
    key = (
        id(program),
        *(None if each is None else (each.shape, each.dtype, each.tobytes()) for each in constants),
    )
    if key not in functions:
        functions[key] = jax.jit(
            lambda *arguments: _evaluated(program, arguments, functions, constants)
        )
    return functions[key]


def _lowest(dtype: Any) -> Any:
    return (
        False
        if dtype.kind == "b"
        else -np.inf
        if jnp.issubdtype(dtype, jnp.floating)
        else np.iinfo(dtype).min
    )


def _highest(dtype: Any) -> Any:
    return (
        True
        if dtype.kind == "b"
        else np.inf
        if jnp.issubdtype(dtype, jnp.floating)
        else np.iinfo(dtype).max
    )


IDENTITIES: dict[
    str, Callable[[Any], Any]
] = {  # reductions, and what an entry is that changes nothing
    "reduce_sum": lambda _: 0,
    "reduce_or": lambda _: 0,
    "reduce_and": lambda dtype: ~np.zeros((), dtype),
    "reduce_max": _lowest,
    "reduce_min": _highest,
    "argmax": _lowest,
    "argmin": _highest,
    "reduce": lambda _: None,  # says so itself
}


def _longer(name: str, params: dict[str, Any], given: list[Any]) -> list[Any]:
    """Returns the operands of a reduction, with one more entry that changes nothing where XLA would make a kernel of it."""
    axes = params["dimensions"] if name == "reduce" else params["axes"]
    size = math.prod(given[0].shape[axis] for axis in axes)
    if size == 1 or size >= WARP or WARP % size:
        return given
    arrays = len(given) // 2 if name == "reduce" else 1
    last = (
        given[arrays:]
        if name == "reduce"
        else [jnp.asarray(IDENTITIES[name](given[0].dtype), given[0].dtype)]
    )
    edges = [(0, int(axis == axes[-1]), 0) for axis in range(given[0].ndim)]
    return [
        *(lax.pad(array, entry, edges) for array, entry in zip(given, last, strict=False)),
        *given[arrays:],
    ]


def _is_comparable(params: dict[str, Any], operand: Array, indices: Array, updates: Array) -> bool:
    """Returns whether a scatter writes entries, or whole rows, of few writers to few places."""
    numbers = params["dimension_numbers"]
    writers = math.prod(indices.shape[:-1])
    return (
        not numbers.operand_batching_dims
        and numbers.inserted_window_dims == tuple(sorted(numbers.scatter_dims_to_operand_dims))
        and numbers.update_window_dims == tuple(range(indices.ndim - 1, updates.ndim))
        and params["mode"] != lax.GatherScatterMode.CLIP
        and 0 < writers <= WARP
        and writers * operand.size <= MOST
    )


def _compared(
    name: str, params: dict[str, Any], scalar: Any, operand: Array, indices: Array, updates: Array
) -> Array:
    """Returns what a scatter does, writer by writer. scalar: what all of them write; None if they differ."""
    written = params["dimension_numbers"].scatter_dims_to_operand_dims
    places = [lax.broadcasted_iota(jnp.int32, operand.shape, dim) for dim in written]
    rows = indices.reshape(-1, len(written)).astype(jnp.int32)
    here = [
        reduce(operator.and_, (place == row[dim] for dim, place in enumerate(places)))
        for row in rows
    ]
    if name == "scatter" and scalar is not None:
        return jnp.where(reduce(operator.or_, here), scalar, operand)
    entry = [1 if dim in written else size for dim, size in enumerate(operand.shape)]
    for there, value in zip(here, updates.reshape(-1, *entry), strict=True):
        operand = (
            jnp.where(there, value, operand)
            if name == "scatter"
            else operand + jnp.where(there, value, jnp.zeros_like(value))
        )
    return operand

"""Checks of what callers hand to an environment: of types and shapes alone, so that a compiled step has none of them."""

from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
from functools import lru_cache
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from sjdsl.runtime.module import GameModule

LOWEST, HIGHEST = -(2**31), 2**31 - 1  # of int32


def refuse_beyond_int32(actions: Any) -> None:
    """Looks at actions before JAX takes them, which cuts longer numbers off: of 2^32 it makes 0. Those that are traced it has cut already.

    Raises ValueError.
    """
    for part in jax.tree.leaves(actions):
        if isinstance(part, jax.core.Tracer) or not isinstance(
            part, int | np.integer | np.ndarray | jax.Array
        ):
            continue
        if not isinstance(part, int) and _fits_int32(part.dtype):
            continue
        for action in np.asarray(part).ravel().tolist():
            if isinstance(action, int) and not LOWEST <= action <= HIGHEST:
                raise ValueError(
                    f"an action is {action}, which is beyond int32; actions are numbers of `action_names`"
                )


def checked_actions(actions: Any, num_agents: int) -> Array:
    """Returns actions as `[N]` int32; what is beyond int32, where JAX computes in 64 bits, is -1, which means `stay`.

    Raises:
      TypeError: they are no whole numbers. ValueError: there is not one for each agent.
    """
    if actions is None or isinstance(actions, Mapping):
        raise TypeError(
            f"actions are numbers, one for each agent in their order, not {type(actions).__name__}"
        )
    given = jnp.asarray(actions)
    if not jnp.issubdtype(given.dtype, jnp.integer):
        raise TypeError(
            f"actions are {given.dtype}, but must be whole numbers, the numbers of actions, such as int32"
        )
    if given.shape != (num_agents,):
        raise ValueError(
            f"actions have shape {given.shape}, one for each agent is wanted: ({num_agents},){_for_a_batch(given.ndim - 1)}"
        )
    if _fits_int32(given.dtype):
        return given.astype(jnp.int32)
    return jnp.where((given < 0) | (given > HIGHEST), -1, given.astype(jnp.int32))


def _fits_int32(dtype: Any) -> bool:
    """Returns whether int32 has all numbers of a dtype."""
    return bool(np.can_cast(dtype, np.int32))


def check_state(module: GameModule, state: Any) -> None:
    """Looks whether a state is one of the game.

    Raises:
      TypeError: it is something else, or the state of another game. ValueError: a part of it has another shape.
    """
    wanted = _shapes(module.initial_state)
    if set(_names(state)) != wanted.keys():
        raise TypeError(
            f"this is not a state of {module.NAME} but {_described(state)}: a state is what `reset` or `step` of the game returned"
        )
    for name in _names(state):
        shape, given = wanted[name].shape, np.shape(getattr(state, name))
        if shape != given:
            raise ValueError(
                f"`{name}` of the state has shape {given}, not {shape}{_for_a_batch(len(given) - len(shape))}"
            )


def check_params(module: GameModule, usual: Any, params: Any) -> None:
    """Looks whether parameters are those of the game. Raises TypeError."""
    if _names(params) != _names(usual):
        raise TypeError(
            f"these are not parameters of {module.NAME} but {_described(params)}: write env.params.replace(name=value)"
        )


@lru_cache(maxsize=256)
def _shapes(initial_state: Callable[[], Any]) -> dict[str, Any]:
    """Returns the shapes and dtypes of a state's parts by name; of a module that plays on NumPy, too, whose states JAX does not know."""
    result: dict[str, Any] = jax.eval_shape(lambda: vars(initial_state()))
    return result


def _names(value: Any) -> tuple[str, ...]:
    return tuple(vars(value)) if hasattr(value, "__dict__") else ()


def _described(value: Any) -> str:
    """Returns what a value is, in the words of a message."""
    if not is_dataclass(value):
        return f"a value of type {type(value).__name__}"
    return f"a {type(value).__name__} with {', '.join(_names(value)[:4])}, …"


def _for_a_batch(axes: int) -> str:
    return "; for a batch of environments, jax.vmap the call" if axes > 0 else ""


def check_arrays(params: Any, own: Any) -> None:
    """Looks whether parameters have the shapes and dtypes of a game's own, also where they are traced.

    A number of Python or NumPy has no dtype that counts: it becomes one of the parameter's.

    Raises ValueError, by the name of the parameter.
    """
    for name in (field.name for field in fields(own)):
        value, wanted = getattr(params, name), getattr(own, name)
        if not isinstance(value, int | float | np.generic | np.ndarray | jax.Array):
            raise ValueError(
                f"`{name}` is {value!r}, and an array is wanted: {_array_text(wanted)}"
            )
        same_dtype = isinstance(value, int | float | np.generic) or jnp.result_type(
            value
        ) == jnp.result_type(wanted)
        if jnp.shape(value) != jnp.shape(wanted) or not same_dtype:
            raise ValueError(
                f"`{name}` is {_array_text(value)}, and {_array_text(wanted)} is wanted"
            )


def _array_text(array: Any) -> str:
    return f"{jnp.result_type(array)}{list(jnp.shape(array))}"

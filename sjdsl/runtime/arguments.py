"""Checks of an environment's arguments: of types and shapes, so that compiled steps have none."""

from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
from functools import lru_cache
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from sjdsl.runtime.module import GameModule

LOWEST = -(2**31)  # of int32
HIGHEST = 2**31 - 1


def refuse_beyond_int32(actions: Any) -> None:
    """Raises ValueError for actions beyond int32, before JAX truncates them: 2^32 becomes 0.

    Traced actions have been truncated already.
    """
    for leaf in jax.tree.leaves(actions):
        is_number = isinstance(leaf, int | np.integer | np.ndarray | jax.Array)
        if isinstance(leaf, jax.core.Tracer) or not is_number:
            continue
        if not isinstance(leaf, int) and _fits_int32(leaf.dtype):
            continue
        for action in np.asarray(leaf).ravel().tolist():
            if isinstance(action, int) and not LOWEST <= action <= HIGHEST:
                raise ValueError(
                    f"an action is {action}, which is beyond int32; actions are numbers of "
                    "`action_names`"
                )


def checked_actions(actions: Any, num_agents: int) -> Array:
    """Returns actions as `[N]` int32.

    Where JAX computes in 64 bits, an action beyond int32 becomes -1, which means `stay`.

    Raises:
      TypeError: they aren't whole numbers.
      ValueError: there isn't one for each agent.
    """
    if actions is None or isinstance(actions, Mapping):
        raise TypeError(
            f"actions are numbers, one for each agent in their order, not {type(actions).__name__}"
        )
    array = jnp.asarray(actions)
    if not jnp.issubdtype(array.dtype, jnp.integer):
        raise TypeError(
            f"actions are {array.dtype}, but must be whole numbers, the numbers of actions, such "
            "as int32"
        )
    if array.shape != (num_agents,):
        raise ValueError(
            f"actions have shape {array.shape}, one for each agent is wanted: ({num_agents},)"
            f"{_for_a_batch(array.ndim - 1)}"
        )
    if _fits_int32(array.dtype):
        return array.astype(jnp.int32)
    return jnp.where((array < 0) | (array > HIGHEST), -1, array.astype(jnp.int32))


def _fits_int32(dtype: Any) -> bool:
    """Returns whether int32 has all numbers of a dtype."""
    return bool(np.can_cast(dtype, np.int32))


def check_state(module: GameModule, state: Any) -> None:
    """Checks that a state is one of the game.

    Raises:
      TypeError: it is something else, or the state of another game.
      ValueError: an array of it has another shape.
    """
    expected = _shapes(module.initial_state)
    if set(_names(state)) != expected.keys():
        raise TypeError(
            f"this is not a state of {module.NAME} but {_described(state)}: a state is what "
            "`reset` or `step` of the game returned"
        )
    for name in _names(state):
        expected_shape = expected[name].shape
        shape = np.shape(getattr(state, name))
        if shape != expected_shape:
            raise ValueError(
                f"`{name}` of the state has shape {shape}, not {expected_shape}"
                f"{_for_a_batch(len(shape) - len(expected_shape))}"
            )


def check_params(module: GameModule, usual: Any, params: Any) -> None:
    """Raises TypeError if params aren't those of the game."""
    if _names(params) != _names(usual):
        raise TypeError(
            f"these are not parameters of {module.NAME} but {_described(params)}: write "
            "env.params.replace(name=value)"
        )


@lru_cache(maxsize=256)
def _shapes(initial_state: Callable[[], Any]) -> dict[str, Any]:
    """Returns the shape and dtype of each array of a state, by name.

    JAX doesn't know the states of a module that plays on NumPy, hence `vars`.
    """
    result: dict[str, Any] = jax.eval_shape(lambda: vars(initial_state()))
    return result


def _names(value: Any) -> tuple[str, ...]:
    return tuple(vars(value)) if hasattr(value, "__dict__") else ()


def _described(value: Any) -> str:
    """Returns the description of a value for a message."""
    if not is_dataclass(value):
        return f"a value of type {type(value).__name__}"
    return f"a {type(value).__name__} with {', '.join(_names(value)[:4])}, …"


def _for_a_batch(axes: int) -> str:
    return "; for a batch of environments, jax.vmap the call" if axes > 0 else ""


def check_arrays(params: Any, defaults: Any) -> None:
    """Raises ValueError if a param, traced or not, has another shape or dtype than the default.

    A number of Python or NumPy may have any dtype: it is converted.
    """
    for field in fields(defaults):
        name = field.name
        value = getattr(params, name)
        default = getattr(defaults, name)
        if not isinstance(value, int | float | np.generic | np.ndarray | jax.Array):
            raise ValueError(
                f"`{name}` is {value!r}, and an array is wanted: {_array_text(default)}"
            )
        is_number = isinstance(value, int | float | np.generic)
        has_dtype = is_number or jnp.result_type(value) == jnp.result_type(default)
        if jnp.shape(value) != jnp.shape(default) or not has_dtype:
            raise ValueError(
                f"`{name}` is {_array_text(value)}, and {_array_text(default)} is wanted"
            )


def _array_text(array: Any) -> str:
    return f"{jnp.result_type(array)}{list(jnp.shape(array))}"

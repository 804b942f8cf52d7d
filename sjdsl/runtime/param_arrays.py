"""The arrays of run-time parameters: their shapes and dtypes."""

from dataclasses import fields
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np


def check_arrays(params: Any, own: Any) -> None:
    """Looks whether parameters have the shapes and dtypes of a game's own, also where they are traced.

    A number of Python or NumPy has no dtype that counts: it becomes one of the parameter's.

    Raises ValueError, by the name of the parameter.
    """
    for name in (field.name for field in fields(own)):
        value, wanted = getattr(params, name), getattr(own, name)
        if not isinstance(value, int | float | np.generic | np.ndarray | jax.Array):
            raise ValueError(f"`{name}` is {value!r}, and an array is wanted: {_told(wanted)}")
        same_dtype = isinstance(value, int | float | np.generic) or jnp.result_type(value) == jnp.result_type(wanted)
        if jnp.shape(value) != jnp.shape(wanted) or not same_dtype:
            raise ValueError(f"`{name}` is {_told(value)}, and {_told(wanted)} is wanted")


def _told(array: Any) -> str:
    return f"{jnp.result_type(array)}{list(jnp.shape(array))}"

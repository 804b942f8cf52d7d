"""Coordinates the processes of a multi-host run: the first one writes files, and all stop together."""

import jax
import numpy as np
from jax import Array


def is_first() -> bool:
    """Whether this process writes files: metrics, policies, checkpoints and the manifest."""
    return jax.process_index() == 0


def any_process(value: bool) -> bool:
    """Whether the value is true in some process; they wait for each other."""
    if jax.process_count() == 1:
        return value
    from jax.experimental.multihost_utils import process_allgather

    return bool(np.any(process_allgather(np.asarray(value))))


def gathered(array: Array) -> np.ndarray:
    """Returns an array in NumPy; the parts that other processes hold are fetched from them, so all have to call it."""
    if array.is_fully_addressable:
        return np.asarray(array)
    from jax.experimental.multihost_utils import process_allgather

    return np.asarray(process_allgather(array, tiled=True))

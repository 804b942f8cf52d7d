"""Coordinates the processes of a multi-host run: the first writes files, and all stop together."""

import jax
import numpy as np


def is_first() -> bool:
    """Whether this process writes metrics, policies and the manifest.

    Every process writes its part of the checkpoints.
    """
    return jax.process_index() == 0


def any_process(value: bool) -> bool:
    """Whether the value is true in some process; they wait for each other."""
    if jax.process_count() == 1:
        return value
    from jax.experimental.multihost_utils import process_allgather

    return bool(np.any(process_allgather(np.asarray(value))))

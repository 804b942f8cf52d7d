"""A checksum of named arrays, checked when stored policies are read."""

import hashlib
from collections.abc import Mapping
from typing import Any

import jax
import numpy as np


def digest_of(arrays: Mapping[str, Any]) -> str:
    """Returns the SHA-256 of arrays, their names, dtypes and shapes."""
    found = hashlib.sha256()
    for name in sorted(arrays):
        array = _gathered(arrays[name])
        found.update(f"{name} {array.dtype} {array.shape}".encode())
        found.update(np.ascontiguousarray(array).tobytes())
    return found.hexdigest()


def _gathered(array: Any) -> np.ndarray:
    """Returns an array in NumPy; the parts that other processes hold are fetched from them."""
    if isinstance(array, jax.Array) and not array.is_fully_addressable:
        from jax.experimental.multihost_utils import process_allgather

        return np.asarray(process_allgather(array, tiled=True))
    return np.asarray(array)

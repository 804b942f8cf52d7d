"""A checksum of named arrays, checked when stored policies and checkpoints are read."""

import hashlib
from collections.abc import Mapping
from typing import Any

import numpy as np


def digest_of(arrays: Mapping[str, Any]) -> str:
    """Returns the SHA-256 of arrays, their names, dtypes and shapes."""
    digest = hashlib.sha256()
    for name in sorted(arrays):
        array = np.asarray(arrays[name])
        digest.update(f"{name} {array.dtype} {array.shape}".encode())
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()

"""Writes files atomically: each is complete or not there."""

import json
import math
import os
import socket
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import jax
import numpy as np

UNFINISHED = ".unfinished"  # ends the name of a file that is being written


def write_json(path: Path, content: Mapping[str, Any], shared: bool = False) -> None:
    """Writes a JSON file whole or not at all; arrays become lists, and what is not finite becomes null."""
    write_whole(path, (json.dumps(plain(content), indent=2, allow_nan=False) + "\n").encode(), shared)


def plain(value: Any) -> Any:
    """Returns a value as JSON has it: arrays as lists, and what is not finite as None."""
    match value:
        case Mapping():
            return {key: plain(entry) for key, entry in value.items()}
        case list() | tuple():
            return [plain(entry) for entry in value]
        case np.ndarray() | np.generic() | jax.Array():
            return plain(np.asarray(value).tolist())
        case float():
            return value if math.isfinite(value) else None
        case _:
            return value


def write_whole(path: Path, content: bytes, shared: bool = False) -> None:
    """Writes a file under another name, to the disk, and then gives it its own. `shared`: several processes may write it at once."""
    writer = f".{socket.gethostname()}.{os.getpid()}" if shared else ""
    unfinished = path.with_name(f"{path.name}{writer}{UNFINISHED}")
    with naming(path), open(unfinished, "wb") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())
    os.replace(unfinished, path)


@contextmanager
def naming(path: Path | str) -> Iterator[None]:
    """Has an OSError say which file could not be written: the system names none when a disk is full."""
    try:
        yield
    except OSError as error:
        error.filename = error.filename or str(path)
        raise

"""Writes results as JSON."""

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import jax
import numpy as np

from sjdsl.files import write_whole


def write_json(path: Path, content: Mapping[str, Any]) -> None:
    """Writes a JSON file whole or not at all; arrays become lists, what isn't finite null."""
    write_whole(path, json_text(content))


def json_text(content: Mapping[str, Any]) -> str:
    """Returns the text of a JSON file; arrays become lists, and what is not finite becomes null."""
    return json.dumps(plain(content), indent=2, allow_nan=False) + "\n"


def plain(value: Any) -> Any:
    """Returns a JSON value: arrays as lists, and what isn't finite as None."""
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

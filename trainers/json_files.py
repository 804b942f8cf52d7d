"""Writes results as JSON."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from pydantic_core import to_jsonable_python

from sjdsl.files import write_whole


def write_json(path: Path, content: Mapping[str, Any]) -> None:
    """Writes a JSON file whole or not at all; arrays become lists, what isn't finite null."""
    write_whole(path, json_text(content))


def json_text(content: Mapping[str, Any]) -> str:
    """Returns the text of a JSON file; arrays become lists, and what is not finite becomes null."""
    return json.dumps(plain(content), indent=2, allow_nan=False) + "\n"


def plain(value: Any) -> Any:
    """Returns a JSON value: arrays as lists, and what isn't finite as None."""
    return to_jsonable_python(
        value, fallback=lambda array: np.asarray(array).tolist(), inf_nan_mode="null"
    )

"""Stores benchmark figures as JSON."""

import dataclasses
import json
from pathlib import Path
from typing import TYPE_CHECKING

from sjdsl.files import write_whole

if TYPE_CHECKING:
    from _typeshed import DataclassInstance


def write_found(path: Path, found: "DataclassInstance") -> None:
    """Writes all figures to a file, and which sort of measurement they are of; a half-written file never stands there."""
    path.parent.mkdir(parents=True, exist_ok=True)
    write_whole(
        path,
        json.dumps({"sort": type(found).__name__.lower(), **dataclasses.asdict(found)}, indent=2)
        + "\n",
    )

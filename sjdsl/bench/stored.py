"""Stores benchmark figures as JSON."""

import dataclasses
import json
from pathlib import Path
from typing import TYPE_CHECKING

from sjdsl.files import write_whole

if TYPE_CHECKING:
    from _typeshed import DataclassInstance


def write_figures(path: Path, figures: "DataclassInstance") -> None:
    """Writes figures to a file, with the name of their class in lower case; writes it whole or not
    at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    content = {"sort": type(figures).__name__.lower(), **dataclasses.asdict(figures)}
    write_whole(path, json.dumps(content, indent=2) + "\n")

"""Stores benchmark figures as JSON and reads them back, so that tables can be made on another machine."""

import dataclasses
import json
from pathlib import Path
from typing import Any

from sjdsl.bench.compilation import Compilation
from sjdsl.bench.extrapolation import Hours
from sjdsl.bench.kernels import Kernels, StepKernels
from sjdsl.bench.resuming import Resume
from sjdsl.bench.substrates import Substrates
from sjdsl.bench.sweep import Sweep
from sjdsl.bench.timing import Report, Speed
from sjdsl.bench.training import Training
from sjdsl.bench.training_split import Split
from sjdsl.files import read_json, write_whole

Found = Report | Substrates | Sweep | Training | Kernels | Resume

_SORTS = {sort.__name__.lower(): sort for sort in (Report, Substrates, Sweep, Training, Kernels, Resume)}
_ROWS: dict[str, type] = {"speeds": Speed, "compilations": Compilation, "splits": Split, "steps": StepKernels, "hours": Hours}  # by field


def write_found(path: Path, found: Found) -> None:
    """Writes all figures to a file, and which sort of measurement they are of; a half-written file never stands there."""
    path.parent.mkdir(parents=True, exist_ok=True)
    write_whole(path, json.dumps({"sort": type(found).__name__.lower(), **dataclasses.asdict(found)}, indent=2) + "\n")


def read_found(path: Path) -> Found:
    """Returns the figures of a file. Raises ValueError where it is not one that `write_found` wrote."""
    try:
        stored = read_json(path)
        sort = _SORTS[stored.pop("sort")]
        return sort(**{name: _value(name, value) for name, value in stored.items()})
    except (KeyError, TypeError, AttributeError, json.JSONDecodeError) as error:
        raise ValueError(f"{path} holds no figures that sjdsl bench wrote ({type(error).__name__}: {error})") from None


def _value(name: str, value: Any) -> Any:
    """Returns what a field holds: rows as their class, lists of numbers as tuples; a row of an older file may lack what has a default."""
    row = _ROWS.get(name)
    if row is not None and isinstance(value, list):
        return tuple(row(**{name: _tuple(figure) for name, figure in entry.items()}) for entry in value)
    return _tuple(value)


def _tuple(value: Any) -> Any:
    return tuple(value) if isinstance(value, list) else value

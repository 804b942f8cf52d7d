"""Reads benchmark figures back, so that tables can be made on another machine."""

from dataclasses import replace
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter

from bench.speed.kernels import Kernels
from bench.speed.resuming import Resume
from bench.speed.substrates import Substrates
from bench.speed.sweep import Sweep
from bench.speed.training import Training
from sjdsl.bench.timing import Report
from sjdsl.files import read_json

Found = Report | Substrates | Sweep | Training | Kernels | Resume

_SORTS: dict[str, TypeAdapter[Any]] = {
    sort.__name__.lower(): TypeAdapter(sort)
    for sort in (Report, Substrates, Sweep, Training, Kernels, Resume)
}


def read_found(path: Path) -> Found:
    """Returns the figures of a file. Raises ValueError where it is not one that `write_found` wrote."""
    try:
        stored = read_json(path)
        found: Found = _SORTS[stored.pop("sort")].validate_python(stored)
        return found
    except (KeyError, TypeError, AttributeError, ValueError) as error:
        raise ValueError(
            f"{path} holds no figures that sjdsl bench wrote ({type(error).__name__}: {error})"
        ) from None


def joined(before: Found, found: Found) -> Found:
    """Returns the figures of two files as one: speeds and updates one after the other. Raises ValueError where they aren't of that sort."""
    if isinstance(before, Report) and isinstance(found, Report):
        peaks = [
            peak for peak in (before.device_peak_bytes, found.device_peak_bytes) if peak is not None
        ]
        rows = before.speeds + found.speeds, before.compilations + found.compilations
        return replace(
            found, speeds=rows[0], compilations=rows[1], device_peak_bytes=max(peaks, default=None)
        )
    if isinstance(before, Training) and isinstance(found, Training):
        return replace(
            found, splits=before.splits + found.splits, left_out=before.left_out + found.left_out
        )
    raise ValueError(f"two files hold figures of one {type(found).__name__.lower()}")

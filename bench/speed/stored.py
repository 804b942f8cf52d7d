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

Figures = Report | Substrates | Sweep | Training | Kernels | Resume

_CLASSES: dict[str, TypeAdapter[Any]] = {
    class_.__name__.lower(): TypeAdapter(class_)
    for class_ in (Report, Substrates, Sweep, Training, Kernels, Resume)
}


def read_figures(path: Path) -> Figures:
    """Returns the figures of a file. Raises ValueError if `write_figures` didn't write it."""
    try:
        stored = read_json(path)
        figures: Figures = _CLASSES[stored.pop("sort")].validate_python(stored)
        return figures
    except (KeyError, TypeError, AttributeError, ValueError) as error:
        raise ValueError(
            f"{path} holds no figures that sjdsl bench wrote ({type(error).__name__}: {error})"
        ) from None


def joined(first: Figures, second: Figures) -> Figures:
    """Returns the figures of two files as one, speeds or updates one after the other.

    Raises ValueError for figures of another class.
    """
    if isinstance(first, Report) and isinstance(second, Report):
        peaks = (first.device_peak_bytes, second.device_peak_bytes)
        return replace(
            second,
            speeds=first.speeds + second.speeds,
            compilations=first.compilations + second.compilations,
            device_peak_bytes=max((peak for peak in peaks if peak is not None), default=None),
        )
    if isinstance(first, Training) and isinstance(second, Training):
        return replace(
            second,
            splits=first.splits + second.splits,
            left_out=first.left_out + second.left_out,
        )
    raise ValueError(f"two files hold figures of one {type(second).__name__.lower()}")

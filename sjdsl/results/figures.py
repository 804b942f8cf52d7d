"""Figures of tables: each once as text, for people, and as numbers, for a CSV. Nothing else formats them."""

import json
import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from sjdsl.results.statistics import Comparison
from sjdsl.trainers.estimates import Estimate, estimate

SHOWN = 4  # digits


@dataclass(frozen=True)
class Figure:
    """A figure: its text, and its numbers by what they are."""

    text: str
    numbers: Mapping[str, Any] = field(default_factory=dict)


EMPTY = Figure("")


@dataclass(frozen=True)
class Cell:
    """One figure of one way of training, by its seeds. Where a seed has failed there is no mean: nothing is averaged without it."""

    run: str
    values: tuple[float, ...]  # of the seeds that are done
    failed: int  # seeds whose loss was not finite
    steps: int  # environment steps of a seed
    preset: str
    hardware: str
    settings: str  # as JSON

    @cached_property
    def estimate(self) -> Estimate | None:
        """The mean over seeds with its 95 % interval by Student's t; None where a seed has failed."""
        return None if self.failed or not self.values else estimate(np.array(self.values))

    @property
    def seeds(self) -> int:
        """How many seeds there are, failed ones included."""
        return len(self.values) + self.failed

    @property
    def origins(self) -> tuple[str, ...]:
        """Seeds, steps, the preset if there is one, and hardware, in words."""
        hardware = " and ".join("unnamed CPU" if name == "cpu" else name for name in self.hardware.split(" and "))
        return counted(self.seeds, "seed"), f"{short(self.steps)} steps", self.preset, hardware

    @property
    def origin(self) -> str:
        """The same as one phrase."""
        return ", ".join(filter(None, self.origins))


def counted(number: int, what: str) -> str:
    """Returns `1 seed`, `3 seeds`."""
    return f"{number} {what}" if number == 1 else f"{number} {what}s"


def number(value: float) -> str:
    """Returns a number in four digits at most: `0.91`, `163.2`, `1,780`."""
    return f"{value:,.0f}" if abs(value) >= 1000 else f"{value + 0.0:.{SHOWN}g}"


def short(value: float) -> str:
    """Returns a large number in three digits at most: `3M`, `1.5M`, `20k`."""
    for size, letter in ((1e9, "G"), (1e6, "M"), (1e3, "k")):
        if value >= size:
            return f"{value / size:.3g}{letter}"
    return f"{value:g}"


def interval(mean: float, low: float | None, high: float | None) -> Figure:
    """Returns `163.2 [160.1, 166.3]`; the mean alone where a bound is None, NaN or infinite, as of one sample."""
    if low is None or high is None or not (math.isfinite(low) and math.isfinite(high)):
        return Figure(number(mean), {"mean": mean})
    return Figure(f"{number(mean)} [{number(low)}, {number(high)}]", {"mean": mean, "low": low, "high": high})


def of_cell(cell: Cell | None) -> Figure:
    """Returns a cell: nothing where there is none, `failed` where a seed has."""
    if cell is None:
        return EMPTY
    behind = {"seeds": cell.seeds, "failed": cell.failed, "steps": cell.steps, "hardware": cell.hardware, "run": cell.run}
    if cell.estimate is None:
        return Figure(f"failed: {cell.failed} of {cell.seeds} seeds" if cell.seeds > 1 else "failed", behind)
    shown = interval(cell.estimate.mean, cell.estimate.low, cell.estimate.high)
    return Figure(shown.text, {**shown.numbers, **behind})


def of_comparison(found: Comparison | None) -> tuple[Figure, Figure]:
    """Returns a difference with its interval, and p; nothing where there is none."""
    if found is None:
        return EMPTY, EMPTY
    p = EMPTY if found.p is None else Figure("< 0.001" if found.p < 0.001 else number(found.p), {"": found.p})
    return interval(found.difference, found.low, found.high), p


def unlike_settings(cells: Mapping[str, Cell | None], but: Collection[str] = ()) -> list[str]:
    """Returns which settings of cells that are read side by side differ, a sentence a setting.

    Args:
      cells: by where each stands.
      but: settings that differ by what the cells are.
    """
    settings = {place: json.loads(cell.settings) for place, cell in cells.items() if cell is not None}
    found = []
    for name in sorted({name for own in settings.values() for name in own} - {*but}):
        places: dict[str, list[str]] = {}
        for place, own in settings.items():
            places.setdefault(json.dumps(own[name]) if name in own else "the default", []).append(place)
        if len(places) > 1:
            said = (f"{value} in {', '.join(named)}" for value, named in places.items())
            found.append(f"`{name}` is {'; '.join(said)}.")
    return found


@dataclass(frozen=True)
class Table:
    """A table: a row a tuple of words and figures, the first `labels` columns words. Its CSV has the numbers behind the texts."""

    name: str  # of its CSV
    title: str
    headings: tuple[str, ...]
    rows: Sequence[Sequence[str | Figure]]
    labels: int = 1

    @property
    def records(self) -> list[dict[str, Any]]:
        """Returns each row as numbers by column: `common mean`, `common low`; words as they are."""
        return [
            {
                f"{heading} {name}".strip(): value
                for heading, cell in zip(self.headings, row, strict=True)
                for name, value in (cell.numbers.items() if isinstance(cell, Figure) else [("", cell)])
            }
            for row in self.rows
        ]

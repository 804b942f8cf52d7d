"""Figures of tables, each both as text and as numbers for a CSV."""

import json
import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from sjdsl.results.statistics import Comparison
from sjdsl.trainers.policies.estimates import Estimate, estimate

SHOWN = 4  # digits


@dataclass(frozen=True)
class Figure:
    """A figure: its text, and its numbers by name."""

    text: str
    numbers: Mapping[str, Any] = field(default_factory=dict)


EMPTY = Figure("")


@dataclass(frozen=True)
class Cell:
    """One figure of one way of training, by seed. It has no mean if a seed has failed."""

    run: str
    values: tuple[float, ...]  # of the finished seeds
    failed: int  # diverged seeds
    steps: int  # environment steps of a seed
    preset: str
    hardware: str
    settings: str  # as JSON

    @cached_property
    def estimate(self) -> Estimate | None:
        """The mean over seeds with its 95 % interval by Student's t; None if a seed has failed."""
        return None if self.failed or not self.values else estimate(np.array(self.values))

    @property
    def seeds(self) -> int:
        """The number of seeds, including failed ones."""
        return len(self.values) + self.failed

    @property
    def origins(self) -> tuple[str, ...]:
        """Seeds, steps, the preset if there is one, and hardware, in words."""
        hardware = " and ".join(
            "unnamed CPU" if name == "cpu" else name for name in self.hardware.split(" and ")
        )
        return counted(self.seeds, "seed"), f"{short(self.steps)} steps", self.preset, hardware

    @property
    def origin(self) -> str:
        """The same as one phrase."""
        return ", ".join(filter(None, self.origins))


def counted(number: int, noun: str) -> str:
    """Returns `1 seed`, `3 seeds`."""
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def number(value: float) -> str:
    """Returns a number with at most four digits: `0.91`, `163.2`, `1,780`."""
    return f"{value:,.0f}" if abs(value) >= 1000 else f"{value + 0.0:.{SHOWN}g}"


def short(value: float) -> str:
    """Returns a large number with at most three digits: `3M`, `1.5M`, `20k`."""
    for size, letter in ((1e9, "G"), (1e6, "M"), (1e3, "k")):
        if value >= size:
            return f"{value / size:.3g}{letter}"
    return f"{value:g}"


def interval(mean: float, low: float | None, high: float | None) -> Figure:
    """Returns `163.2 [160.1, 166.3]`; just the mean if a bound is None, NaN or infinite, as for one
    sample.
    """
    if low is None or high is None or not (math.isfinite(low) and math.isfinite(high)):
        return Figure(number(mean), {"mean": mean})
    return Figure(
        f"{number(mean)} [{number(low)}, {number(high)}]", {"mean": mean, "low": low, "high": high}
    )


def of_cell(cell: Cell | None) -> Figure:
    """Returns the figure of a cell: empty for None, `failed` if a seed has failed."""
    if cell is None:
        return EMPTY
    origin = {
        "seeds": cell.seeds,
        "failed": cell.failed,
        "steps": cell.steps,
        "hardware": cell.hardware,
        "run": cell.run,
    }
    if cell.estimate is None:
        seeds = f": {cell.failed} of {cell.seeds} seeds" if cell.seeds > 1 else ""
        return Figure(f"failed{seeds}", origin)
    figure = interval(cell.estimate.mean, cell.estimate.low, cell.estimate.high)
    return Figure(figure.text, {**figure.numbers, **origin})


def of_comparison(comparison: Comparison | None) -> tuple[Figure, Figure]:
    """Returns a difference with its interval, and p; both empty for None."""
    if comparison is None:
        return EMPTY, EMPTY
    difference = interval(comparison.difference, comparison.low, comparison.high)
    p = comparison.p
    if p is None:
        return difference, EMPTY
    return difference, Figure("< 0.001" if p < 0.001 else number(p), {"": p})


def unlike_settings(cells: Mapping[str, Cell | None], but: Collection[str] = ()) -> list[str]:
    """Returns the settings in which cells of one comparison differ, one sentence each.

    Args:
      cells: by the name of their column.
      but: settings that are meant to differ.
    """
    settings = {
        column: json.loads(cell.settings) for column, cell in cells.items() if cell is not None
    }
    names = {name for of_column in settings.values() for name in of_column}
    sentences = []
    for name in sorted(names.difference(but)):
        columns: dict[str, list[str]] = {}  # value -> the columns that have it
        for column, of_column in settings.items():
            value = json.dumps(of_column[name]) if name in of_column else "the default"
            columns.setdefault(value, []).append(column)
        if len(columns) == 1:
            continue
        fresh = columns.get("the default", [])
        if name == "init_from" and fresh:
            trained = ", ".join(column for column in settings if column not in fresh)
            sentences.append(
                f"the seeds of {trained} started from a trained policy; "
                f"those of {', '.join(fresh)} didn't."
            )
        else:
            values = [f"{value} in {', '.join(having)}" for value, having in columns.items()]
            sentences.append(f"`{name}` is {'; '.join(values)}.")
    return sentences


@dataclass(frozen=True)
class Table:
    """A table of text and figures, with text in the first `labels` columns. Its CSV has the numbers
    of the figures."""

    name: str  # of its CSV
    title: str
    headings: tuple[str, ...]
    rows: Sequence[Sequence[str | Figure]]
    labels: int = 1

    @property
    def records(self) -> list[dict[str, Any]]:
        """Each row as numbers by column, such as `common mean` and `common low`; text unchanged."""
        records = []
        for row in self.rows:
            record: dict[str, Any] = {}
            for heading, cell in zip(self.headings, row, strict=True):
                numbers = cell.numbers if isinstance(cell, Figure) else {"": cell}
                for name, value in numbers.items():
                    record[f"{heading} {name}".strip()] = value
            records.append(record)
        return records

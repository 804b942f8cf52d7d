"""Figures of tables, each both as text and as numbers for a CSV."""

import json
import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from sjdsl.results.statistics import Comparison
from sjdsl.trainers.policies.estimates import Estimate, estimate, number


@dataclass(frozen=True)
class Figure:
    """A figure: its text, and its numbers by name."""

    text: str
    numbers: Mapping[str, Any] = field(default_factory=dict)


EMPTY = Figure("")


@dataclass(frozen=True)
class Result:
    """One figure of the seeds that were trained in one way. It has no mean if a seed has failed."""

    run: str
    values: tuple[float, ...]  # of the finished seeds
    failed: int  # diverged seeds
    steps: int  # environment steps of a seed
    preset: str
    hardware: str
    settings: str  # JSON of those that aren't the default

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
        """Four phrases: seeds, steps, the preset or an empty text, and hardware."""
        devices = self.hardware.split(" and ")
        hardware = " and ".join("unnamed CPU" if name == "cpu" else name for name in devices)
        return counted(self.seeds, "seed"), f"{short(self.steps)} steps", self.preset, hardware

    @property
    def origin(self) -> str:
        """Seeds, steps, the preset if there is one, and hardware, as one phrase."""
        return ", ".join(filter(None, self.origins))


def counted(number: int, noun: str) -> str:
    """Returns `1 seed`, `3 seeds`."""
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def short(value: float) -> str:
    """Returns a large number with at most three digits: `3M`, `1.5M`, `20k`."""
    for size, letter in ((1e9, "G"), (1e6, "M"), (1e3, "k")):
        if value >= size:
            return f"{value / size:.3g}{letter}"
    return f"{value:g}"


def interval(mean: float, low: float | None, high: float | None) -> Figure:
    """Returns `163.2 [160.1, 166.3]`, rounded as an `Estimate` is; just the mean if a bound is None,
    NaN or infinite, as for one sample.
    """
    if low is None or high is None or not (math.isfinite(low) and math.isfinite(high)):
        return Figure(number(mean), {"mean": mean})
    return Figure(str(Estimate(mean, low, high)), {"mean": mean, "low": low, "high": high})


def result_figure(result: Result | None) -> Figure:
    """Returns the figure of a result: empty for None, `failed` if a seed has failed."""
    if result is None:
        return EMPTY
    origin = {
        "seeds": result.seeds,
        "failed": result.failed,
        "steps": result.steps,
        "hardware": result.hardware,
        "run": result.run,
    }
    if result.estimate is None:
        seeds = f": {result.failed} of {result.seeds} seeds" if result.seeds > 1 else ""
        return Figure(f"failed{seeds}", origin)
    figure = interval(result.estimate.mean, result.estimate.low, result.estimate.high)
    return Figure(figure.text, {**figure.numbers, **origin})


def comparison_figures(comparison: Comparison | None) -> tuple[Figure, Figure]:
    """Returns a difference with its interval, and p; both empty for None."""
    if comparison is None:
        return EMPTY, EMPTY
    difference = interval(comparison.difference, comparison.low, comparison.high)
    p = comparison.p
    if p is None:
        return difference, EMPTY
    return difference, Figure("< 0.001" if p < 0.001 else f"{p:.2g}", {"": p})


def differing_settings(
    results: Mapping[str, Result | None], meant: Collection[str] = ()
) -> list[str]:
    """Returns the settings in which results of one comparison differ, one sentence each.

    Args:
      results: by the name of their column.
      meant: settings that are meant to differ, and left out.
    """
    settings = {
        column: json.loads(result.settings)
        for column, result in results.items()
        if result is not None
    }
    names = {name for of_column in settings.values() for name in of_column}
    sentences = []
    for name in sorted(names.difference(meant)):
        by_value: dict[str, list[str]] = {}  # value -> the columns that have it
        for column, of_column in settings.items():
            value = json.dumps(of_column[name]) if name in of_column else "the default"
            by_value.setdefault(value, []).append(column)
        if len(by_value) == 1:
            continue
        untrained = by_value.get("the default", [])
        if name == "init_from" and untrained:
            trained = ", ".join(column for column in settings if column not in untrained)
            sentences.append(
                f"the seeds of {trained} started from a trained policy; "
                f"those of {', '.join(untrained)} didn't."
            )
        else:
            values = [f"{value} in {', '.join(columns)}" for value, columns in by_value.items()]
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

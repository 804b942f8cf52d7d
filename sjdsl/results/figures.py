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


def counted(number: int, what: str) -> str:
    """Returns `1 seed`, `3 seeds`."""
    return f"{number} {what}" if number == 1 else f"{number} {what}s"


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
    """Returns `163.2 [160.1, 166.3]`; just the mean if a bound is None, NaN or infinite, as for one sample."""
    if low is None or high is None or not (math.isfinite(low) and math.isfinite(high)):
        return Figure(number(mean), {"mean": mean})
    return Figure(
        f"{number(mean)} [{number(low)}, {number(high)}]", {"mean": mean, "low": low, "high": high}
    )


def of_cell(cell: Cell | None) -> Figure:
    """Returns the figure of a cell: empty for None, `failed` if a seed has failed."""
    if cell is None:
        return EMPTY
    behind = {
        "seeds": cell.seeds,
        "failed": cell.failed,
        "steps": cell.steps,
        "hardware": cell.hardware,
        "run": cell.run,
    }
    if cell.estimate is None:
        return Figure(
            f"failed: {cell.failed} of {cell.seeds} seeds" if cell.seeds > 1 else "failed", behind
        )
    shown = interval(cell.estimate.mean, cell.estimate.low, cell.estimate.high)
    return Figure(shown.text, {**shown.numbers, **behind})


def of_comparison(found: Comparison | None) -> tuple[Figure, Figure]:
    """Returns a difference with its interval, and p; both empty for None."""
    if found is None:
        return EMPTY, EMPTY
    p = (
        EMPTY
        if found.p is None
        else Figure("< 0.001" if found.p < 0.001 else number(found.p), {"": found.p})
    )
    return interval(found.difference, found.low, found.high), p


def unlike_settings(cells: Mapping[str, Cell | None], but: Collection[str] = ()) -> list[str]:
    """Returns the settings in which cells of one comparison differ, one sentence each.

    Args:
      cells: by the name of their column.
      but: settings that are meant to differ.
    """
    settings = {
        place: json.loads(cell.settings) for place, cell in cells.items() if cell is not None
    }
    found = []
    for name in sorted({name for own in settings.values() for name in own} - {*but}):
        places: dict[str, list[str]] = {}
        for place, own in settings.items():
            places.setdefault(json.dumps(own[name]) if name in own else "the default", []).append(
                place
            )
        fresh = places.get("the default", [])
        if name == "init_from" and fresh and len(places) > 1:
            begun = ", ".join(place for place in settings if place not in fresh)
            found.append(
                f"the seeds of {begun} started from a trained policy; those of {', '.join(fresh)} didn't."
            )
        elif len(places) > 1:
            said = (f"{value} in {', '.join(named)}" for value, named in places.items())
            found.append(f"`{name}` is {'; '.join(said)}.")
    return found


@dataclass(frozen=True)
class Table:
    """A table of words and figures, with words in the first `labels` columns. Its CSV has the numbers of the figures."""

    name: str  # of its CSV
    title: str
    headings: tuple[str, ...]
    rows: Sequence[Sequence[str | Figure]]
    labels: int = 1

    @property
    def records(self) -> list[dict[str, Any]]:
        """Each row as numbers by column, such as `common mean` and `common low`; words unchanged."""
        return [
            {
                f"{heading} {name}".strip(): value
                for heading, cell in zip(self.headings, row, strict=True)
                for name, value in (
                    cell.numbers.items() if isinstance(cell, Figure) else [("", cell)]
                )
            }
            for row in self.rows
        ]

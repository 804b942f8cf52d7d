"""Small multiples: a plot a game, our means with their intervals beside the published ones."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from sjdsl.results.drawing import PUBLISHED, colours
from sjdsl.trainers.estimates import Estimate

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLUMNS = 3
WIDTH, HEIGHT = 3.6, 2.8  # inches of a plot


@dataclass(frozen=True)
class Series:
    """Our figures over x: means and the ends of their intervals, `[P]` each; NaN where one sample has no interval."""

    x: np.ndarray
    mean: np.ndarray
    low: np.ndarray
    high: np.ndarray
    label: str = "ours"

    @classmethod
    def of(cls, figures: Iterable[tuple[float, Estimate]], label: str = "ours") -> "Series":
        """Returns the series of estimates over x."""
        pairs = list(figures)
        x, mean = np.array([x for x, _ in pairs]), np.array([figure.mean for _, figure in pairs])
        low, high = (np.array([getattr(figure, end) for _, figure in pairs], float) for end in ("low", "high"))
        return cls(x, mean, np.where(np.isfinite(low), low, np.nan), np.where(np.isfinite(high), high, np.nan), label)


@dataclass(frozen=True)
class Multiple:
    """One plot: our series, and the published points."""

    title: str
    series: tuple[Series, ...]
    printed: tuple[tuple[float, float], ...]


def panel_of(title: str, series: Series, printed: Sequence[tuple[float, float]]) -> Multiple:
    """Returns a plot of one series of ours beside the published one."""
    return Multiple(title, (series,), tuple(printed))


def draw_series(plots: Sequence[Multiple], x_title: str, y_title: str, logarithmic: bool = False) -> "Figure":
    """Returns a figure with a plot a game, three in a row; bars are 95 % intervals."""
    from matplotlib.figure import Figure  # here: importing it costs as much as a short test

    rows, columns = math.ceil(len(plots) / COLUMNS), min(COLUMNS, len(plots))
    figure = Figure(figsize=(max(5.0, WIDTH * columns), HEIGHT * rows + 0.3), layout="constrained")
    with colours():
        for number, plot in enumerate(plots, 1):
            axes = figure.add_subplot(rows, columns, number)
            _draw(axes, plot, logarithmic)
            axes.set_title(plot.title, fontsize="medium")
    figure.supxlabel(x_title, fontsize="medium")
    figure.supylabel(y_title, fontsize="medium")
    return figure


def _draw(axes: "Axes", plot: Multiple, logarithmic: bool) -> None:
    for series in plot.series:
        below, above = series.mean - series.low, series.high - series.mean
        known = np.isfinite(below) & np.isfinite(above)
        bars = np.stack([np.where(known, below, 0.0), np.where(known, above, 0.0)])
        axes.errorbar(series.x, series.mean, bars, label=series.label, marker="o", markersize=4, linewidth=1.5, capsize=3)
    if plot.printed:
        axes.plot(*zip(*plot.printed, strict=True), label="published", **PUBLISHED)
    if logarithmic:
        axes.set_xscale("log")
        axes.set_yscale("log")
    axes.grid(alpha=0.3)
    axes.legend(fontsize="x-small")

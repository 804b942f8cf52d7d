"""Small multiples: a plot a game, our means with their intervals beside the published ones."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from sjdsl.render.plot_style import (
    BLACK,
    PUBLISHED,
    Label,
    begin_at_zero,
    line_colour,
    name_lines,
    note_below,
    plot_style,
)
from sjdsl.trainers.policies.estimates import Estimate, stack_estimates

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLUMNS = 3
WIDTH = 4.2  # inches of a plot
HEIGHT = 2.8


@dataclass(frozen=True)
class Series:
    """Our figures over x: means and the ends of their intervals, `[P]` each; NaN where one sample
    has no interval.
    """

    x: np.ndarray
    mean: np.ndarray
    low: np.ndarray
    high: np.ndarray
    label: str = "ours"

    @classmethod
    def of(cls, figures: Iterable[tuple[float, Estimate]]) -> "Series":
        """Returns the series of estimates over x."""
        pairs = list(figures)
        mean, low, high = stack_estimates(figure for _, figure in pairs)
        return cls(
            x=np.array([x for x, _ in pairs]),
            mean=mean,
            low=np.where(np.isfinite(low), low, np.nan),
            high=np.where(np.isfinite(high), high, np.nan),
        )


@dataclass(frozen=True)
class Multiple:
    """One plot: our series, and the published points."""

    title: str
    series: tuple[Series, ...]
    printed: tuple[tuple[float, float], ...]


def draw_series(
    plots: Sequence[Multiple],
    x_title: str,
    y_title: str,
    logarithmic: bool = False,
    bars: str = "95 % intervals",
) -> "Figure":
    """Returns a figure with a plot a game, three in a row, over the same x. bars: what they are, in
    words.
    """
    from matplotlib.figure import Figure  # here: importing it costs as much as a short test

    rows = math.ceil(len(plots) / COLUMNS)
    columns = min(COLUMNS, len(plots))
    colours: dict[str, str] = {}
    for plot in plots:
        for series in plot.series:
            colours.setdefault(series.label, line_colour(len(colours)))
    drawn: list[Axes] = []
    with plot_style():
        figure = Figure(
            figsize=(max(5.0, WIDTH * columns), HEIGHT * rows + 0.6), layout="constrained"
        )
        for number, plot in enumerate(plots, 1):
            axes = figure.add_subplot(rows, columns, number, sharex=drawn[0] if drawn else None)
            axes.tick_params(labelbottom=True)
            axes.set_title(plot.title)
            _draw(axes, plot, colours, logarithmic)
            drawn.append(axes)
        for axes, plot in zip(drawn, plots, strict=True):
            labels = [
                Label(series.label, series.mean[-1], colours[series.label])
                for series in plot.series
            ]
            if plot.printed:
                _, last = plot.printed[-1]
                labels.append(Label("published", last, BLACK))
            name_lines(axes, labels)
        figure.supylabel(y_title, fontsize="medium")
        note_below(figure, f"Over {x_title}. Bars: {bars}.")
    return figure


def _draw(axes: "Axes", plot: Multiple, colours: Mapping[str, str], logarithmic: bool) -> None:
    """Draws one plot. colours: by the label of a series."""
    ends: list[float] = [y for _, y in plot.printed]
    for series in plot.series:
        below = series.mean - series.low
        above = series.high - series.mean
        known = np.isfinite(below) & np.isfinite(above)
        bars = np.stack([np.where(known, below, 0.0), np.where(known, above, 0.0)])
        axes.errorbar(
            series.x,
            series.mean,
            bars,
            color=colours[series.label],
            marker="o",
            markersize=4,
            linewidth=1.5,
            capsize=3,
        )
        ends += [*series.mean, *series.low, *series.high]
    if plot.printed:
        x, y = zip(*plot.printed, strict=True)
        axes.plot(x, y, **PUBLISHED)
    if logarithmic:
        axes.set_xscale("log")
        axes.set_yscale("log")
    else:
        begin_at_zero(axes, ends)

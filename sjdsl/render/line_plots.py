"""Plots lines over environment steps, with at most five lines in a plot."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import count, pairwise
from math import ceil
from typing import TYPE_CHECKING

import numpy as np

from sjdsl.extras import needs
from sjdsl.render.plot_style import (
    FAINT,
    Label,
    begin_at_zero,
    line_colour,
    name_lines,
    note_below,
    plot_style,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST = 5  # lines of a plot that can be told apart
WIDTH = 5.6  # inches of a plot
HEIGHT = 3.4
COLUMNS = 3  # plots side by side, at most


@dataclass(frozen=True)
class Line:
    """One line. steps, values, low, high: `[P]`; the range from `low` to `high` is shaded."""

    label: str
    steps: np.ndarray
    values: np.ndarray
    low: np.ndarray | None = None
    high: np.ndarray | None = None
    colour: str | None = None  # None: one that no other line of the figure has
    least: float | None = None  # the smallest single measurement behind it, if that is not in `low`

    @property
    def extent(self) -> tuple[float, float]:
        """The smallest and the largest measurement."""
        least = np.nanmin(self.values if self.low is None else self.low)
        most = np.nanmax(self.values if self.high is None else self.high)
        return float(least if self.least is None else self.least), float(most)


@dataclass(frozen=True)
class Panel:
    """One plot."""

    title: str  # above it, may be empty
    y_title: str  # what is drawn, in words
    lines: tuple[Line, ...]
    marks: tuple[float, ...] = ()  # steps at which a dotted line is drawn


def split_lines(lines: Sequence[Line], y_title: str) -> list[Panel]:
    """Returns the fewest plots with at most five lines each, filled as evenly as possible."""
    plots = ceil(len(lines) / MOST)
    bounds = [round(number * len(lines) / plots) for number in range(plots + 1)]
    return [Panel("", y_title, tuple(lines[first:last])) for first, last in pairwise(bounds)]


def draw_panels(panels: Sequence[Panel], title: str = "", note: str = "") -> "Figure":
    """Returns a figure with the plots in rows; plots with the same y title have the same range.

    Args:
      note: below it, what its bands are.
    """
    with needs("plots"):
        from matplotlib.figure import Figure  # here: importing it costs as much as a short test
        from matplotlib.ticker import EngFormatter

    columns = min(COLUMNS, len(panels))
    rows = ceil(len(panels) / columns)
    height = HEIGHT * rows
    if title:
        height += 0.4
    if note:
        height += 0.3
    like: dict[str, Axes] = {}  # y title -> the first plot that has it
    first: Axes | None = None
    labels: list[list[Label]] = []
    numbers = count()
    with plot_style():
        figure = Figure(figsize=(max(7.0, WIDTH * columns), height), layout="constrained")
        for number, panel in enumerate(panels, 1):
            axes = figure.add_subplot(
                rows, columns, number, sharey=like.get(panel.y_title), sharex=first
            )
            first = first or axes
            like.setdefault(panel.y_title, axes)
            labels.append([_draw_line(axes, line, next(numbers)) for line in panel.lines])
            for mark in panel.marks:
                axes.axvline(mark, color=FAINT, linestyle=":")
            axes.set(xlabel="environment steps", ylabel=panel.y_title, title=panel.title)
            axes.xaxis.set_major_formatter(EngFormatter(sep=""))
            axes.set_xlim(left=0)
        for y_title, axes in like.items():
            begin_at_zero(axes, _extents(panels, y_title))
        for axes, names in zip(figure.axes, labels, strict=True):
            name_lines(axes, names)
        if title:
            figure.suptitle(title)
        note_below(figure, note)
    return figure


def _draw_line(axes: "Axes", line: Line, number: int) -> Label:
    """Draws a line, and returns its name."""
    colour = line.colour or line_colour(number)
    marker = "o" if len(line.steps) == 1 else ""  # without one, a single point is invisible
    axes.plot(line.steps, line.values, marker=marker, color=colour, label=line.label)
    if line.low is not None and line.high is not None:
        axes.fill_between(line.steps, line.low, line.high, color=colour, alpha=0.2, linewidth=0)
    return Label(line.label, line.values[-1], colour)


def _extents(panels: Sequence[Panel], y_title: str) -> Iterator[float]:
    """Yields the smallest and the largest measurements of the plots that have a y title."""
    for panel in panels:
        if panel.y_title == y_title:
            for line in panel.lines:
                yield from line.extent

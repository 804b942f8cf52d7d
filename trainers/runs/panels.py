"""Plots lines over environment steps, with at most five lines in a panel."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
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
WIDTH, HEIGHT = 5.6, 3.4  # inches of a plot
COLUMNS = 3  # plots side by side, at most


@dataclass(frozen=True)
class Line:
    """One line. steps, values, low, high: `[P]`; the range from `low` to `high` is shaded.

    colour: None for one that no other line of the figure has. least: the smallest single measurement behind it, if that is not in `low`.
    """

    label: str
    steps: np.ndarray
    values: np.ndarray
    low: np.ndarray | None = None
    high: np.ndarray | None = None
    colour: str | None = None
    least: float | None = None


@dataclass(frozen=True)
class Panel:
    """One plot. title: above it, may be empty; y_title: what is drawn, in words; marks: steps at which a dotted line is drawn."""

    title: str
    y_title: str
    lines: tuple[Line, ...]
    marks: tuple[float, ...] = ()


def split_lines(lines: Sequence[Line], y_title: str) -> list[Panel]:
    """Returns the fewest plots with at most five lines each, filled as evenly as possible."""
    count = -(-len(lines) // MOST)
    bounds = [round(number * len(lines) / count) for number in range(count + 1)]
    return [Panel("", y_title, tuple(lines[first:last])) for first, last in pairwise(bounds)]


def draw_panels(panels: Sequence[Panel], title: str = "", note: str = "") -> "Figure":
    """Returns a figure with the plots in rows; plots with the same y title have the same range. note: below it, what its bands are."""
    with needs("plots"):
        from matplotlib.figure import Figure  # here: importing it costs as much as a short test
        from matplotlib.ticker import EngFormatter

    columns = min(COLUMNS, len(panels))
    rows = -(-len(panels) // columns)
    drawn: list[Axes] = []
    names: list[list[Label]] = []
    colours = {
        line.label: line_colour(number)
        for number, line in enumerate(line for panel in panels for line in panel.lines)
    }
    with plot_style():
        figure = Figure(
            figsize=(
                max(7.0, WIDTH * columns),
                HEIGHT * rows + 0.4 * bool(title) + 0.3 * bool(note),
            ),
            layout="constrained",
        )
        for number, panel in enumerate(panels, 1):
            like = next(
                (
                    axes
                    for axes, other in zip(drawn, panels, strict=False)
                    if other.y_title == panel.y_title
                ),
                None,
            )
            axes = figure.add_subplot(
                rows, columns, number, sharey=like, sharex=drawn[0] if drawn else None
            )
            for line in panel.lines:
                marker = (
                    "o" if len(line.steps) == 1 else ""
                )  # a single point would be invisible without a marker
                colour = line.colour or colours[line.label]
                axes.plot(line.steps, line.values, marker=marker, color=colour, label=line.label)
                if line.low is not None and line.high is not None:
                    axes.fill_between(
                        line.steps, line.low, line.high, color=colour, alpha=0.2, linewidth=0
                    )
            for mark in panel.marks:
                axes.axvline(mark, color=FAINT, linestyle=":")
            names.append(
                [
                    Label(line.label, line.values[-1], line.colour or colours[line.label])
                    for line in panel.lines
                ]
            )
            axes.set(xlabel="environment steps", ylabel=panel.y_title, title=panel.title)
            axes.xaxis.set_major_formatter(EngFormatter(sep=""))
            axes.set_xlim(left=0)
            drawn.append(axes)
        for axes, panel in zip(drawn, panels, strict=True):
            alike = [
                line for other in panels if other.y_title == panel.y_title for line in other.lines
            ]
            begin_at_zero(axes, [value for line in alike for value in _smallest_and_largest(line)])
        for axes, labels in zip(drawn, names, strict=True):
            name_lines(axes, labels)
        if title:
            figure.suptitle(title)
        note_below(figure, note)
    return figure


def _smallest_and_largest(line: Line) -> tuple[float, float]:
    below = (
        line.least
        if line.least is not None
        else np.nanmin(line.values if line.low is None else line.low)
    )
    return float(below), float(np.nanmax(line.values if line.high is None else line.high))

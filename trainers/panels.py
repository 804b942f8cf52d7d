"""Plots lines over environment steps, with at most five lines in a panel."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from sjdsl.extras import needs

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST = 5  # lines of a plot that can be told apart
WIDTH, HEIGHT = 5.0, 3.6  # inches of a plot
COLUMNS = 3  # plots side by side, at most


@dataclass(frozen=True)
class Line:
    """One line. steps, values, low, high: `[P]`; the range from `low` to `high` is shaded."""

    label: str
    steps: np.ndarray
    values: np.ndarray
    low: np.ndarray | None = None
    high: np.ndarray | None = None


@dataclass(frozen=True)
class Panel:
    """One plot. title: above it, may be empty; y_title: what is drawn, in words."""

    title: str
    y_title: str
    lines: tuple[Line, ...]


def split_lines(lines: Sequence[Line], y_title: str) -> list[Panel]:
    """Returns the fewest plots with at most five lines each, filled as evenly as possible."""
    count = -(-len(lines) // MOST)
    bounds = [round(number * len(lines) / count) for number in range(count + 1)]
    return [Panel("", y_title, tuple(lines[first:last])) for first, last in pairwise(bounds)]


def draw_panels(panels: Sequence[Panel], title: str = "") -> "Figure":
    """Returns a figure with the plots in rows; plots with the same y title have the same range."""
    with needs("plots"):
        from matplotlib.figure import Figure  # here: importing it costs as much as a short test
        from matplotlib.ticker import EngFormatter

    columns = min(COLUMNS, len(panels))
    rows = -(-len(panels) // columns)
    figure = Figure(figsize=(max(7.0, WIDTH * columns), HEIGHT * rows + 0.4 * bool(title)), layout="constrained")
    drawn: list[Axes] = []
    for number, panel in enumerate(panels, 1):
        like = next((axes for axes, other in zip(drawn, panels, strict=False) if other.y_title == panel.y_title), None)
        axes = figure.add_subplot(rows, columns, number, sharey=like, sharex=drawn[0] if drawn else None)
        for line in panel.lines:
            marker = "o" if len(line.steps) == 1 else ""  # a single point would be invisible without a marker
            (shown,) = axes.plot(line.steps, line.values, marker=marker, label=line.label)
            if line.low is not None and line.high is not None:
                axes.fill_between(line.steps, line.low, line.high, color=shown.get_color(), alpha=0.25, linewidth=0)
        axes.set(xlabel="environment steps", ylabel=panel.y_title, title=panel.title)
        axes.xaxis.set_major_formatter(EngFormatter(sep=""))
        axes.grid(alpha=0.3)
        axes.legend(fontsize="small")
        drawn.append(axes)
    if title:
        figure.suptitle(title)
    return figure

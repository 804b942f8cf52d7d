"""How every plot looks: the colours of agents and of pages, a name at the end of each line, axes that begin at 0 where nothing is below it."""

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np

from sjdsl.render.colours import (
    AGENTS,
    INK,
    PAPER,
    WORDS,
    Colour,
    agent_colour,
    hexadecimal,
    mixed,
    read_colour,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

BLACK, FAINT = hexadecimal(INK), hexadecimal(mixed(INK, PAPER, 0.4))
COOPERATE, DEFECT = hexadecimal(WORDS["cooperate"]), hexadecimal(WORDS["defect"])
PUBLISHED: dict[str, Any] = {"color": BLACK, "linestyle": "--", "marker": "x", "linewidth": 1}
LABEL = 22  # letters of a line of a label
_LINE = 0.052  # of the height of a plot, by which a line of text moves the next label
# Colours that lines are told apart by: those of agents, the first two exchanged, without what can't be seen on white.
_LUMINANCE = (0.2126, 0.7152, 0.0722)


def _is_seen(colour: Colour) -> bool:
    return float(np.dot(colour, _LUMINANCE)) < 175


PALETTE = tuple(
    hexadecimal(colour) for colour in (AGENTS[1], AGENTS[0], *AGENTS[2:]) if _is_seen(colour)
)


def line_colour(number: int) -> str:
    """Returns the colour of a line; of few lines no two have the same."""
    return PALETTE[number % len(PALETTE)]


def agent_line_colour(agent: int) -> str:
    """Returns the colour that an agent has on boards and pages, darker where it can't be seen on white."""
    colour = agent_colour(agent)
    return hexadecimal(colour if _is_seen(colour) else mixed(colour, read_colour("black"), 0.3))


@contextmanager
def plot_style() -> Iterator[None]:
    """Draws plots in the style of all: its colours, no frame but the axes, a faint grid."""
    import matplotlib  # here: importing it costs as much as a short test
    from cycler import cycler

    style: Any = {
        "axes.prop_cycle": cycler(color=PALETTE),
        "axes.spines.top": False,
        "axes.spines.right": False,
        "axes.edgecolor": FAINT,
        "axes.labelcolor": BLACK,
        "axes.titlesize": "medium",
        "axes.titlelocation": "left",
        "axes.grid": True,
        "axes.axisbelow": True,
        "grid.alpha": 0.25,
        "text.color": BLACK,
        "xtick.color": FAINT,
        "xtick.labelcolor": BLACK,
        "ytick.color": FAINT,
        "ytick.labelcolor": BLACK,
        "figure.titlesize": "large",
    }
    with matplotlib.rc_context(style):
        yield


@dataclass(frozen=True)
class Label:
    """A name beside a line. at: the height at which the line ends, as data."""

    text: str
    at: float
    colour: str


def name_lines(axes: "Axes", labels: Sequence[Label]) -> None:
    """Writes the name of each line right of the plot, at the height of its end, or as near to it as no other name is."""
    labels = sorted(
        (label for label in labels if label.text and np.isfinite(label.at)),
        key=lambda label: label.at,
    )
    if not labels:
        return
    texts = [fill(label.text, LABEL) for label in labels]
    axes.get_ylim()  # transLimits doesn't bring limits that follow the data up to date
    ends = axes.transLimits.transform(
        [(0, axes.transScale.transform((1, label.at))[1]) for label in labels]
    )[:, 1]
    style: Any = {
        "xycoords": "axes fraction",
        "va": "center",
        "fontsize": "small",
        "linespacing": 1.0,
        "annotation_clip": False,
    }
    for label, text, place in zip(
        labels,
        texts,
        apart(list(ends), [_LINE * (text.count("\n") + 1) for text in texts]),
        strict=True,
    ):
        axes.annotate(text, (1.02, place), color=label.colour, **style)


def apart(wanted: Sequence[float], heights: Sequence[float]) -> list[float]:
    """Returns the middles of labels, given from below to above, near where they are wanted, so that none overlaps the next.

    Labels that would overlap share a stack around the mean of their places; stacks stay above 0.
    """
    from scipy.optimize import isotonic_regression  # here: importing it takes a while

    below = np.cumsum(heights) - np.divide(
        heights, 2
    )  # how high the middle of each would be if all stood on one another
    middles: list[float] = (
        np.maximum(isotonic_regression(np.subtract(wanted, below)).x, 0) + below
    ).tolist()
    return middles


def begin_at_zero(axes: "Axes", values: Iterable[float]) -> None:
    """Has the y axis begin at 0 if nothing that it shows, or no single measurement, is below 0."""
    known = [value for value in values if np.isfinite(value)]
    if known and min(known) >= 0:
        axes.set_ylim(bottom=0, top=None if max(known) > 0 else 1)


def note_below(figure: Any, text: str) -> None:
    """Writes what lines, bands and bars are below a figure, in small letters."""
    if text:
        figure.supxlabel(text, fontsize="small", color=FAINT, x=0.01, ha="left")

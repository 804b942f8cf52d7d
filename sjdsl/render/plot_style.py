"""How every plot looks: the colours of agents and pages, and a name at the end of each line."""

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

BLACK = hexadecimal(INK)
FAINT = hexadecimal(mixed(INK, PAPER, 0.4))
COOPERATE = hexadecimal(WORDS["cooperate"])
DEFECT = hexadecimal(WORDS["defect"])
PUBLISHED: dict[str, Any] = {"color": BLACK, "linestyle": "--", "marker": "x", "linewidth": 1}
LABEL = 22  # letters in a line of a label
_LINE = 0.052  # height of a line of text, as a share of the plot's height
_LUMINANCE = (0.2126, 0.7152, 0.0722)  # of red, green and blue (ITU-R BT.709)
_BRIGHT = 175  # of 255: from here on a colour is too pale on white


def _is_visible(colour: Colour) -> bool:
    """Returns whether a colour can be seen on white."""
    return float(np.dot(colour, _LUMINANCE)) < _BRIGHT


# Colours of lines: those of agents, the first two exchanged.
PALETTE = tuple(
    hexadecimal(colour) for colour in (AGENTS[1], AGENTS[0], *AGENTS[2:]) if _is_visible(colour)
)


def line_colour(number: int) -> str:
    """Returns the colour of a line; of few lines no two have the same."""
    return PALETTE[number % len(PALETTE)]


def agent_line_colour(agent: int) -> str:
    """Returns an agent's colour on boards and pages, darker if it can't be seen on white."""
    colour = agent_colour(agent)
    if not _is_visible(colour):
        colour = mixed(colour, read_colour("black"), 0.3)
    return hexadecimal(colour)


@contextmanager
def plot_style() -> Iterator[None]:
    """Applies the style of all plots inside a `with` block."""
    import matplotlib  # here because importing it takes as long as a short test
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
    """A name beside a line. at: the value at which the line ends."""

    text: str
    at: float
    colour: str


def name_lines(axes: "Axes", labels: Sequence[Label]) -> None:
    """Writes the name of each line right of the plot, near its end, without overlaps."""
    labels = sorted(
        (label for label in labels if label.text and np.isfinite(label.at)),
        key=lambda label: label.at,
    )
    if not labels:
        return
    texts = [fill(label.text, LABEL) for label in labels]
    axes.get_ylim()  # brings limits that follow the data up to date, which transLimits doesn't
    scaled = [(0, axes.transScale.transform((1, label.at))[1]) for label in labels]
    ends = axes.transLimits.transform(scaled)[:, 1]
    heights = [_LINE * (text.count("\n") + 1) for text in texts]
    style: Any = {
        "xycoords": "axes fraction",
        "va": "center",
        "fontsize": "small",
        "linespacing": 1.0,
        "annotation_clip": False,
    }
    for label, text, y in zip(labels, texts, spread(list(ends), heights), strict=True):
        axes.annotate(text, (1.02, y), color=label.colour, **style)


def spread(wanted: Sequence[float], heights: Sequence[float]) -> list[float]:
    """Returns the middles of labels near where they are wanted, such that none overlap.

    Labels that would overlap share a stack around the mean of their wanted middles; no label
    reaches below 0.

    Args:
      wanted: middles, in increasing order.
      heights: of the labels, in the same unit.
    """
    from scipy.optimize import isotonic_regression  # here because importing it takes a while

    stacked = np.cumsum(heights) - np.divide(heights, 2)  # middles of one stack of all labels
    shifts = isotonic_regression(np.subtract(wanted, stacked)).x
    middles: list[float] = (np.maximum(shifts, 0) + stacked).tolist()
    return middles


def begin_at_zero(axes: "Axes", values: Iterable[float]) -> None:
    """Lets the y axis begin at 0 unless a value is negative."""
    known = [value for value in values if np.isfinite(value)]
    if known and min(known) >= 0:
        axes.set_ylim(bottom=0, top=None if max(known) > 0 else 1)


def note_below(figure: Any, text: str) -> None:
    """Writes a note below a figure, in small letters."""
    if text:
        figure.supxlabel(text, fontsize="small", color=FAINT, x=0.01, ha="left")

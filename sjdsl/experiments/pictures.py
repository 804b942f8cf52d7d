"""Pictures of experiments: the Schelling diagram, and the matrix of pairs."""

import io
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from sjdsl.experiments.diagram import Diagram
from sjdsl.experiments.mixtures import CrossPlay
from sjdsl.render.plot_style import (
    BLACK,
    COOPERATE,
    DEFECT,
    Label,
    begin_at_zero,
    name_lines,
    note_below,
    plot_style,
)
from sjdsl.trainers.policies.estimates import Estimate

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LEGIBLE = 24  # letters of a policy's name


def draw_diagram(found: Diagram) -> "Figure":
    """Returns both lines over the number of other cooperators, with 95 % bands, and dotted the mean of all agents over k."""
    from matplotlib.figure import Figure  # here: importing it costs as much as a short test
    from matplotlib.ticker import MaxNLocator

    everybody = [figure.mean for figure in found.everybody]
    lines = (
        ("cooperates", found.cooperating, COOPERATE, "o"),
        ("defects", found.defecting, DEFECT, "s"),
    )
    with plot_style():
        figure = Figure(figsize=(7.4, 4.6), layout="constrained")
        axes = figure.add_subplot()
        for _, line, colour, marker in lines:
            _draw_line(axes, line, colour, marker)
        axes.plot(range(len(everybody)), everybody, color=BLACK, linestyle=":", linewidth=1)
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
        axes.set(xlabel="number of other agents that cooperate", ylabel="return of an agent")
        ends = [
            end
            for _, line, _, _ in lines
            for figure_ in line
            for end in (figure_.mean, figure_.low, figure_.high)
        ]
        begin_at_zero(axes, [*ends, *everybody])
        named = [
            Label(f"an agent that {what}", line[-1].mean, colour) for what, line, colour, _ in lines
        ]
        name_lines(axes, [*named, Label("mean of all agents", everybody[-1], BLACK)])
        verdict = found.verdict
        title = f"{found.experiment.title}: {verdict.outcome}" + (
            f", {verdict.shape}" if verdict.outcome == "dilemma" else ""
        )
        spread = "; the verdict rests on samples without spread" if verdict.without_spread else ""
        axes.set_title(f"{title}\n{found.population}{spread}")
        note_below(
            figure,
            "Bands: 95 % intervals. The dotted line is over the number of all agents that cooperate.",
        )
    return figure


def _draw_line(axes: "Axes", line: Sequence[Estimate], colour: str, marker: str) -> None:
    places = range(len(line))
    axes.plot(places, [figure.mean for figure in line], color=colour, marker=marker)
    low, high = (np.array([getattr(figure, key) for figure in line]) for key in ("low", "high"))
    bounded = np.isfinite(low)
    axes.fill_between(
        places,
        np.where(bounded, low, np.nan),
        np.where(bounded, high, np.nan),
        color=colour,
        alpha=0.2,
        linewidth=0,
    )


def draw_matrix(found: CrossPlay) -> "Figure":
    """Returns the mean return of an agent of each row's policy where all others have the column's, as a table of colours."""
    from matplotlib.figure import Figure

    values, names = found.matrix(), [_short(name) for name in found.short_names]
    size = 2.5 + 0.9 * len(names)
    with plot_style():
        figure = Figure(figsize=(size + 1, size), layout="constrained")
        axes = figure.add_subplot()
        shown = axes.imshow(values, cmap="viridis")
        middle = (values.max() + values.min()) / 2
        for (row, column), value in np.ndenumerate(values):
            axes.text(
                column,
                row,
                f"{value:.4g}",
                ha="center",
                va="center",
                color="black" if value > middle else "white",
            )
        axes.grid(visible=False)
        axes.set_xticks(range(len(names)), names, rotation=45, ha="right")
        axes.set_yticks(range(len(names)), names)
        axes.set(
            xlabel="policy of all others",
            ylabel="policy of one agent",
            title=found.experiment.title,
        )
        figure.colorbar(shown, shrink=0.7, label="return of the one agent")
    return figure


def _short(name: str) -> str:
    """Returns the end of a long name, which tells runs apart."""
    return name if len(name) <= LEGIBLE else f"…{name[1 - LEGIBLE :]}"


def picture_bytes(figure: "Figure", ending: str) -> bytes:
    """Returns a picture as the bytes of a PNG or SVG; the same picture is the same bytes."""
    import matplotlib

    content = io.BytesIO()
    metadata: dict[str, Any] = {"Date": None} if ending == "svg" else {"Software": None}
    with matplotlib.rc_context({"svg.hashsalt": "sjdsl"}):
        figure.savefig(content, format=ending, dpi=120, metadata=metadata)
    return content.getvalue()

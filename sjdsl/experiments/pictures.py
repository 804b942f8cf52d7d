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
from sjdsl.trainers.policies.estimates import Estimate, stack_estimates

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LEGIBLE = 24  # letters of a policy's name


def draw_diagram(diagram: Diagram) -> "Figure":
    """Returns both lines over the number of other cooperators, with 95 % bands, and, over an axis
    of its own at the top, the mean of all agents as a dotted line."""
    from matplotlib.figure import Figure  # importing it costs as much as a short test
    from matplotlib.ticker import MaxNLocator

    everybody = [mean.mean for mean in diagram.everybody]
    verdict = diagram.verdict
    title = f"{diagram.experiment.title}: {verdict.outcome}"
    if verdict.outcome == "dilemma":
        title += f", {verdict.shape}"
    title += f"\n{diagram.population}"
    if verdict.without_spread:
        title += "; the verdict rests on samples without spread"
    with plot_style():
        figure = Figure(figsize=(7.4, 4.6), layout="constrained")
        axes = figure.add_subplot()
        _draw_line(axes, diagram.cooperating, COOPERATE, "o")
        _draw_line(axes, diagram.defecting, DEFECT, "s")
        axes.plot(range(len(everybody)), everybody, color=BLACK, linestyle=":", linewidth=1)
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
        top = axes.secondary_xaxis("top")
        top.xaxis.set_major_locator(MaxNLocator(integer=True))
        top.set_xlabel("dotted line: number of all agents that cooperate")
        axes.set(xlabel="number of other agents that cooperate", ylabel="return of an agent")
        columns = stack_estimates((*diagram.cooperating, *diagram.defecting))
        begin_at_zero(axes, [*np.concatenate(columns), *everybody])
        labels = [
            Label("an agent that cooperates", diagram.cooperating[-1].mean, COOPERATE),
            Label("an agent that defects", diagram.defecting[-1].mean, DEFECT),
            Label("mean of all agents", everybody[-1], BLACK),
        ]
        name_lines(axes, labels)
        axes.set_title(title)
        note_below(figure, "Bands: 95 % intervals.")
    return figure


def _draw_line(axes: "Axes", line: Sequence[Estimate], colour: str, marker: str) -> None:
    """Draws estimates for l = 0 .. N-1 with a band for their intervals, where these are finite."""
    numbers = range(len(line))
    mean, low, high = stack_estimates(line)
    axes.plot(numbers, mean, color=colour, marker=marker)
    axes.fill_between(
        numbers,
        np.where(np.isfinite(low), low, np.nan),
        np.where(np.isfinite(low), high, np.nan),
        color=colour,
        alpha=0.2,
        linewidth=0,
    )


def draw_matrix(results: CrossPlay) -> "Figure":
    """Returns the mean return of an agent of each row's policy where all others have the column's,
    as a table of colours."""
    from matplotlib.figure import Figure

    values = results.matrix()
    names = [_short(name) for name in results.short_names]
    size = 2.5 + 0.9 * len(names)
    with plot_style():
        figure = Figure(figsize=(size + 1, size), layout="constrained")
        axes = figure.add_subplot()
        image = axes.imshow(values, cmap="viridis")
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
            title=results.experiment.title,
        )
        figure.colorbar(image, shrink=0.7, label="return of the one agent")
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

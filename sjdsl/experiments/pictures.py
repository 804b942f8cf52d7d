"""Pictures of experiments: the Schelling diagram, and the matrix of pairs."""

import io
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from sjdsl.experiments.diagram import Diagram
from sjdsl.experiments.mixtures import CrossPlay
from sjdsl.trainers.estimates import Estimate

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COOPERATORS, DEFECTORS = "tab:blue", "tab:red"
LEGIBLE = 24  # letters of a policy's name


def draw_diagram(found: Diagram) -> "Figure":
    """Returns both lines over the number of other cooperators, with 95 % bands, and dotted the mean of all agents over k."""
    from matplotlib.figure import Figure  # here: importing it costs as much as a short test
    from matplotlib.ticker import MaxNLocator

    figure = Figure(figsize=(6.4, 4.4), layout="constrained")
    axes = figure.add_subplot()
    _draw_line(axes, found.cooperating, "choosing to cooperate", COOPERATORS, "o")
    _draw_line(axes, found.defecting, "choosing to defect", DEFECTORS, "s")
    everybody = [figure.mean for figure in found.everybody]
    axes.plot(range(len(everybody)), everybody, color="black", linestyle=":", linewidth=1, label="mean of all agents, over all cooperators")
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.set(xlabel="number of other agents that cooperate", ylabel="return of an agent")
    verdict = found.verdict
    title = f"{found.experiment.title}: {verdict.outcome}" + (f", {verdict.shape}" if verdict.outcome == "dilemma" else "")
    spread = "; the verdict rests on samples without spread" if verdict.without_spread else ""
    axes.set_title(f"{title}\n{found.population}{spread}", fontsize="medium")
    axes.grid(alpha=0.3)
    axes.legend(fontsize="small")
    return figure


def _draw_line(axes: "Axes", line: Sequence[Estimate], label: str, colour: str, marker: str) -> None:
    places = range(len(line))
    axes.plot(places, [figure.mean for figure in line], color=colour, marker=marker, label=label)
    low, high = (np.array([getattr(figure, key) for figure in line]) for key in ("low", "high"))
    bounded = np.isfinite(low)
    axes.fill_between(places, np.where(bounded, low, np.nan), np.where(bounded, high, np.nan), color=colour, alpha=0.2, linewidth=0)


def draw_matrix(found: CrossPlay) -> "Figure":
    """Returns the mean return of an agent of each row's policy where all others have the column's, as a table of colours."""
    from matplotlib.figure import Figure

    values, names = found.matrix(), [_short(name) for name in found.names]
    size = 2.5 + 0.9 * len(names)
    figure = Figure(figsize=(size + 1, size), layout="constrained")
    axes = figure.add_subplot()
    shown = axes.imshow(values, cmap="viridis")
    middle = (values.max() + values.min()) / 2
    for (row, column), value in np.ndenumerate(values):
        axes.text(column, row, f"{value:.4g}", ha="center", va="center", color="black" if value > middle else "white")
    axes.set_xticks(range(len(names)), names, rotation=45, ha="right")
    axes.set_yticks(range(len(names)), names)
    axes.set(xlabel="policy of all others", ylabel="policy of one agent", title=f"{found.experiment.title}: return of the one")
    figure.colorbar(shown, shrink=0.7)
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

"""Draws the learning curve of one seed: the collective return, how learning goes, and the return of each agent."""

from collections.abc import Sequence
from dataclasses import replace
from io import BytesIO
from pathlib import Path

import numpy as np

from sjdsl.extras import is_installed
from sjdsl.files import write_whole
from sjdsl.render.plot_style import FAINT, agent_line_colour, line_colour

from .learning_signs import FIGURES
from .metrics_files import Row
from .panels import Line, Panel, draw_panels, split_lines

LEARNING_CURVE = "learning_curve.png"
STAGES_NOTE = "Dotted lines: where a stage begins."


def draw_learning_curve(folder: Path, rows: Sequence[Row], title: str) -> None:
    """Draws the raw returns of finished episodes over environment steps; nothing if none finished, or without matplotlib."""
    panels = curve_panels(rows)
    if not panels or not is_installed("matplotlib"):
        return
    picture = BytesIO()
    draw_panels(panels, title, STAGES_NOTE * bool(panels[0].marks)).savefig(
        picture, format="png", dpi=120
    )
    write_whole(folder / LEARNING_CURVE, picture.getvalue())


def curve_panels(rows: Sequence[Row]) -> list[Panel]:
    """Returns the plots: none if no episode has ended, and none of single agents if there is only one."""
    ended = [row for row in rows if row["episodes"] > 0]
    if not ended:
        return []
    steps = np.array([row["env_steps"] for row in ended])

    def line(name: str, label: str, colour: str) -> Line:
        return Line(
            label, steps, np.array([row.get(name, np.nan) for row in ended], float), colour=colour
        )

    firsts: dict[
        float, Row
    ] = {}  # the first row of each stage, played by the policy that the stage began with
    for row in ended:
        firsts.setdefault(row.get("stage", 0), row)
    before = np.array([firsts[row.get("stage", 0)]["collective_return"] for row in ended])
    earned = (
        line("collective_return", "all agents", line_colour(0)),
        Line("before learning", steps, before, colour=FAINT),
    )
    together = Panel("all agents together", "collective return of an episode", earned)
    figures = {
        label: np.array([row.get(name, np.nan) for row in rows], float)
        for name, label in FIGURES.items()
    }
    updates = np.array([row["env_steps"] for row in rows])
    learning = [
        Panel(label, label, (Line("", updates, values, colour=line_colour(0)),))
        for label, values in figures.items()
        if np.isfinite(values).any()  # none is, if the first loss wasn't
    ]
    names = [name for name in ended[-1] if name.startswith("return_agent_")]
    agents = [
        line(name, f"agent {number}", agent_line_colour(number))
        for number, name in enumerate(names)
    ]
    for panel in split_lines(agents, "return of an agent in an episode") if len(agents) > 1 else ():
        first, last = (
            line.label.removeprefix("agent ") for line in (panel.lines[0], panel.lines[-1])
        )
        learning.append(
            replace(panel, title=f"agents {first} to {last}" if first != last else f"agent {first}")
        )
    marks = tuple(row["env_steps"] for row in [*firsts.values()][1:])
    return [replace(panel, marks=marks) for panel in (together, *learning)]

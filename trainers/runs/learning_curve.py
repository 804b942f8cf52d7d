"""Draws the learning curve of one seed: returns, together and of each agent, and how it learns."""

from collections.abc import Sequence
from dataclasses import replace
from io import BytesIO
from pathlib import Path

import numpy as np

from sjdsl.extras import is_installed
from sjdsl.files import write_whole
from sjdsl.render.line_plots import Line, Panel, draw_panels, split_lines
from sjdsl.render.plot_style import FAINT, agent_line_colour, line_colour

from .learning_signs import FIGURES
from .metrics_files import Row

LEARNING_CURVE = "learning_curve.png"
STAGES_NOTE = "Dotted lines: where a stage begins."


def draw_learning_curve(folder: Path, rows: Sequence[Row], title: str) -> None:
    """Draws the raw returns of finished episodes over environment steps.

    It draws nothing if none finished, or without matplotlib.
    """
    panels = curve_panels(rows)
    if not panels or not is_installed("matplotlib"):
        return
    note = STAGES_NOTE if panels[0].marks else ""
    picture = BytesIO()
    draw_panels(panels, title, note).savefig(picture, format="png", dpi=120)
    write_whole(folder / LEARNING_CURVE, picture.getvalue())


def curve_panels(rows: Sequence[Row]) -> list[Panel]:
    """Returns the plots: none if no episode has ended, none of agents if there is only one."""
    ended = [row for row in rows if row["episodes"] > 0]
    if not ended:
        return []
    # the first row of each stage, played by the policy that the stage began with
    firsts: dict[float, Row] = {}
    for row in ended:
        firsts.setdefault(row.get("stage", 0), row)
    before = [firsts[row.get("stage", 0)] for row in ended]
    steps = _column(ended, "env_steps")
    returns = (
        _line(ended, "collective_return", "all agents", line_colour(0)),
        Line("before learning", steps, _column(before, "collective_return"), colour=FAINT),
    )
    panels = [Panel("all agents together", "collective return of an episode", returns)]
    for name, label in FIGURES.items():
        line = _line(rows, name, "", line_colour(0))
        if np.isfinite(line.values).any():  # none is, if the first loss wasn't
            panels.append(Panel(label, label, (line,)))
    names = [name for name in ended[-1] if name.startswith("return_agent_")]
    if len(names) > 1:
        agents = [
            _line(ended, name, f"agent {number}", agent_line_colour(number))
            for number, name in enumerate(names)
        ]
        panels += [
            replace(panel, title=f"{panel.lines[0].label} to {panel.lines[-1].label}")
            for panel in split_lines(agents, "return of an agent in an episode")
        ]
    _, *later_stages = firsts.values()
    marks = tuple(row["env_steps"] for row in later_stages)
    return [replace(panel, marks=marks) for panel in panels]


def _line(rows: Sequence[Row], name: str, label: str, colour: str) -> Line:
    """Returns a column of rows as a line over environment steps."""
    return Line(label, _column(rows, "env_steps"), _column(rows, name), colour=colour)


def _column(rows: Sequence[Row], name: str) -> np.ndarray:
    """Returns a column of rows, NaN where it is missing."""
    return np.array([row.get(name, np.nan) for row in rows], float)

"""Learning curves of several runs in one picture: the mean over seeds, and the range from the lowest to the highest."""

import json
import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from .metrics_files import METRICS_JSONL, Row
from .resuming import RunError, read_manifest

POINTS = 200  # of a curve: updates are averaged to as many


def column(rows: Sequence[Row], metric: str) -> np.ndarray:
    """Returns a figure of each row, NaN where it has none.

    Args:
      rows: of `metrics.jsonl`.
      metric: a column; or several joined by `+`, perhaps divided by several: `event_own/event_own+event_other`. What is counted
        for each agent is added up.
    Raises:
      RunError: no such column.
    """
    above, _, below = metric.partition("/")
    total = _sum(rows, above)
    return total / _sum(rows, below) if below else total


def _sum(rows: Sequence[Row], names: str) -> np.ndarray:
    total = np.zeros(len(rows))
    for name in names.split("+"):
        found = [key for key in rows[0] if key == name or key.startswith(f"{name}_agent_")]
        exact = [name] if name in rows[0] else found
        if not exact:
            raise RunError(f"the metrics have no column `{name}`; they have {', '.join(rows[0])}")
        for key in exact:
            total = total + np.array([math.nan if row[key] is None else row[key] for row in rows], float)
    return total


def read_seeds(run_dir: Path) -> list[list[Row]]:
    """Returns the rows of each seed of a run.

    Raises:
      RunError: no such run, or it has no metrics yet.
    """
    read_manifest(run_dir)
    folders = sorted(run_dir.glob("seed_*")) or [run_dir]
    seeds = [[json.loads(line) for line in (folder / METRICS_JSONL).read_text().splitlines()] for folder in folders]
    if not all(seeds):
        raise RunError(f"{run_dir} has no metrics yet")
    return seeds


def draw_curves(runs: Sequence[tuple[str, Path]], metric: str, path: Path) -> None:
    """Draws a metric of runs, `(label, folder)`, over environment steps.

    Raises:
      RunError: a run has no such metric.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7, 4), layout="constrained")
    axes = figure.add_subplot()
    for label, folder in runs:
        seeds = read_seeds(folder)
        length = min(len(rows) for rows in seeds)
        steps = np.array([row["env_steps"] for row in seeds[0][:length]])
        values = np.stack([column(rows[:length], metric) for rows in seeds])
        known = np.isfinite(values).all(axis=0)
        steps, values = _thinned(steps[known], values[:, known])
        (line,) = axes.plot(steps, values.mean(axis=0), label=f"{label}, {len(seeds)} seed{'s' if len(seeds) > 1 else ''}")
        axes.fill_between(steps, values.min(axis=0), values.max(axis=0), color=line.get_color(), alpha=0.25, linewidth=0)
    axes.set(xlabel="environment steps", ylabel=metric)
    axes.grid(alpha=0.3)
    axes.legend(fontsize="small")
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=110)


def _thinned(steps: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Returns at most `POINTS` points, each the mean of as many updates."""
    size = max(1, math.ceil(len(steps) / POINTS))
    pieces = range(0, len(steps), size)
    return steps[::size], np.stack([values[:, start : start + size].mean(axis=1) for start in pieces], axis=1)

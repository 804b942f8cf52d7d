"""Plots learning curves of several runs in one picture: means over seeds, and their range."""

import math
from array import array
from collections.abc import Iterable, Sequence
from functools import lru_cache
from pathlib import Path

import numpy as np

from sjdsl.files import written_whole
from sjdsl.render.line_plots import Line, draw_panels, split_lines

from .manifest import read_manifest
from .metrics_files import Row, run_rows
from .run_errors import RunError

POINTS = 200  # of a curve, at most; updates are averaged
# Prefixes of columns, and what they are of an episode.
OF_AN_EPISODE = {
    "event_": "{} in an episode",
    "mean_": "mean of {} over an episode",
    "final_": "{} at the end of an episode",
}


def read_seeds(run_dir: Path, metric: str) -> list[np.ndarray]:
    """Returns the environment steps and a metric of each update of each seed: `float64[2, T]` each.

    Args:
      run_dir: a folder that `sjdsl train` wrote. Its rows are read one at a time, as those of a
        long run don't fit into memory.
      metric: a column of `metrics.jsonl`; without `_agent_N`, counts of single agents are added up.
        NaN where there is no value.
    Raises:
      RunError: no such run, no such column, or no metrics yet.
    """
    read_manifest(run_dir)
    folders = sorted(run_dir.glob("seed_*")) or [run_dir]
    seeds = [figures(run_rows(folder), metric) for folder in folders]
    if not all(seed.size for seed in seeds):
        raise RunError(f"{run_dir} has no metrics yet")
    return seeds


def figures(rows: Iterable[Row], metric: str) -> np.ndarray:
    """Returns the environment steps and a metric of each row, `float64[2, T]`; see `read_seeds`."""
    values = array("d")  # of each row two
    for row in rows:
        columns = _columns(tuple(row), metric)
        values.append(row["env_steps"])
        values.append(math.fsum(row[name] for name in columns))
    return np.array(values).reshape(-1, 2).T


@lru_cache
def _columns(known: tuple[str, ...], name: str) -> tuple[str, ...]:
    """Returns the columns of a name: itself, or one for each agent."""
    if name in known:
        return (name,)
    of_agents = tuple(key for key in known if key.startswith(f"{name}_agent_"))
    if not of_agents:
        raise RunError(f"the metrics have no column `{name}`; they have {', '.join(known)}")
    return of_agents


def draw_curves(
    runs: Sequence[tuple[str, Path]], metric: str, path: Path, by_trial: bool = False
) -> None:
    """Draws a metric of runs, `(label, folder)`, over environment steps, at most five in a plot.

    by_trial: draws a line for each trial of an episode.

    Raises:
      RunError: a run has no such metric, or no value of it yet, or no trials.
    """
    lines = []
    for label, folder in runs:
        if by_trial:
            lines += [
                curve_line(f"{label}, trial {trial}", folder, f"{metric}_trial_{trial}")
                for trial in range(_trials_of(folder, metric))
            ]
        else:
            lines.append(curve_line(label, folder, metric))
    path.parent.mkdir(parents=True, exist_ok=True)
    note = ""
    if any(line.low is not None for line in lines):
        note = "Lines: means over seeds. Bands: from the lowest seed to the highest."
    picture = draw_panels(split_lines(lines, in_words(metric)), note=note)
    with written_whole(path) as file:
        picture.savefig(file, format=path.suffix.removeprefix(".") or "png", dpi=110)


def _trials_of(folder: Path, metric: str) -> int:
    """Returns how many trials a run has a metric of. Raises RunError if there are none."""
    read_manifest(folder)
    seeds = sorted(folder.glob("seed_*")) or [folder]
    first_row = next(run_rows(seeds[0]), {})
    prefix = f"{metric}_trial_"
    trials = sum(column.startswith(prefix) for column in first_row)
    if not trials:
        raise RunError(
            f"{folder} has no `{metric}` by trial: its game has no trials, or no such metric"
        )
    return trials


def curve_line(label: str, folder: Path, metric: str) -> Line:
    """Returns the mean of a metric over a run's seeds, and its range."""
    seeds = read_seeds(folder, metric)
    length = min(seed.shape[1] for seed in seeds)
    steps = seeds[0][0, :length]
    values = np.stack([seed[1, :length] for seed in seeds])
    known = np.isfinite(values).all(axis=0)
    if not known.any():
        raise RunError(
            f"{folder} has no value of `{metric}` in any update, so there is no curve to draw. "
            "Perhaps no episode ended in the run"
        )
    steps = steps[known]
    values = values[:, known]
    size = math.ceil(len(steps) / POINTS)  # updates of a point
    starts = range(0, len(steps), size)
    values = np.stack([values[:, start : start + size].mean(axis=1) for start in starts], axis=1)
    steps = steps[::size]
    if len(seeds) == 1:
        return Line(f"{label}, 1 seed", steps, values[0])
    label = f"{label}, {len(seeds)} seeds"
    return Line(label, steps, values.mean(axis=0), values.min(axis=0), values.max(axis=0))


def in_words(metric: str) -> str:
    """Returns a column in words: `event_own_agent_1` is `own of agent 1 in an episode`."""
    prefix = next((prefix for prefix in OF_AN_EPISODE if metric.startswith(prefix)), "")
    name, _, agent = metric.removeprefix(prefix).partition("_agent_")
    words = name.replace("_", " ")
    if agent:
        words += f" of agent {agent}"
    return OF_AN_EPISODE.get(prefix, "{}").format(words)

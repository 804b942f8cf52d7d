"""Flattens nested metrics into one row of named numbers."""

import math
from collections.abc import Sequence
from typing import Any

import jax
import numpy as np

from ..algorithms.episodes import without_value
from .metrics_files import Row


def flatten_metrics(metrics: dict[str, Any]) -> Row:
    """Returns metrics as flat numbers.

    `{"event": {"eaten": [3, 4]}}` becomes `event_eaten_agent_0` and `…_1`. Raw and shaped returns
    are per agent; their means over agents are `return` and `shaped_return`. Figures of trials,
    summed over agents, are `collective_return_trial_0` and so on. A missing value is NaN.
    """
    row: Row = {}
    absent = without_value(metrics)
    for name, value in metrics.items():
        if name in absent:
            value = jax.tree.map(lambda leaf: np.full(np.shape(leaf), np.nan), value)
        if name in ("agent_return", "shaped_agent_return"):
            short = name.replace("agent_", "")
            row[short] = float(np.mean(value))
            row |= _per_agent(short, value)
        elif name == "by_trial":
            for inner, figures in value.items():
                for trial, figure in enumerate(np.asarray(figures)):
                    row[f"{inner}_trial_{trial}"] = figure.item()
        elif isinstance(value, dict):
            for inner, count in value.items():
                row |= _per_agent(f"{name}_{inner}", count)
        elif name != "equalities":
            row |= _per_agent(name, value)
    return row


def _per_agent(name: str, value: Any) -> Row:
    """Returns one number as it is, and of `[N]` one for each agent: `NAME_agent_0`."""
    if np.ndim(value) == 0:
        return {name: np.asarray(value).item()}
    return {f"{name}_agent_{index}": entry.item() for index, entry in enumerate(np.asarray(value))}


def mean_row(rows: Sequence[Row]) -> Row:
    """Returns the mean of the rows of several seeds, without missing values."""
    means = dict(rows[0])
    for name in means.keys() - {"update", "env_steps", "stage"}:
        known = [row[name] for row in rows if not math.isnan(row[name])]
        means[name] = sum(known) / len(known) if known else math.nan
    return means

"""Flattens nested metrics into one row of named numbers."""

from collections.abc import Sequence
from typing import Any

import jax
import numpy as np

from ..algorithms.episodes import without_value
from .metrics_files import Row


def flatten_metrics(metrics: dict[str, Any]) -> Row:
    """Returns metrics as flat numbers: `{"event": {"eaten": [3, 4]}}` becomes `event_eaten_agent_0` and `…_1`.

    Raw and shaped returns are per agent; their means over agents are `return` and `shaped_return`. A missing value is NaN.
    """
    row: Row = {}
    absent = without_value(metrics)
    for name, measured in metrics.items():
        value = (
            jax.tree.map(lambda leaf: np.full(np.shape(leaf), np.nan), measured)
            if name in absent
            else measured
        )
        match name:
            case "equalities":
                pass
            case "agent_return" | "shaped_agent_return":
                short = name.replace("agent_", "")
                row[short] = float(np.mean(value))
                row |= _per_agent(short, value)
            case "event" | "mean" | "final" | "metric":
                for inner, count in value.items():
                    row |= _per_agent(f"{name}_{inner}", count)
            case _:
                row |= _per_agent(name, value)
    return row


def _per_agent(name: str, value: Any) -> Row:
    if np.ndim(value) == 0:
        return {name: np.asarray(value).item()}
    return {f"{name}_agent_{index}": entry.item() for index, entry in enumerate(np.asarray(value))}


def mean_row(rows: Sequence[Row]) -> Row:
    """Returns the mean of the rows of several seeds, without missing values."""
    means = {}
    for name in rows[0]:
        known = [row[name] for row in rows if row[name] == row[name]]
        means[name] = sum(known) / len(known) if known else float("nan")
    return means | {
        name: rows[0][name] for name in ("update", "env_steps", "stage") if name in rows[0]
    }

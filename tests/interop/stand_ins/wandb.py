"""Stands in for Weights & Biases: what is logged goes to the file that WANDB_LOG names, a line of JSON each; nothing in the mode `disabled`."""

import json
import os
from typing import Any

import numpy as np

SETTINGS: dict[str, Any] = {}  # of the run


class Video:
    """A film, which is not kept."""

    def __init__(self, path: str, **described: Any) -> None:
        del path, described


def init(**settings: Any) -> None:
    """Begins a run."""
    SETTINGS.update(settings)


def log(metrics: dict[str, Any], step: Any = None) -> None:
    """Keeps numbers as numbers, arrays as their means and films as their name."""
    del step
    if SETTINGS.get("mode") == "disabled":
        return
    kept = {name: type(value).__name__ if isinstance(value, Video) else float(np.mean(value)) for name, value in metrics.items()}
    with open(os.environ["WANDB_LOG"], "a", encoding="utf-8") as file:
        file.write(json.dumps(kept) + "\n")

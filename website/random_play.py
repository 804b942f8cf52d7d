"""What a random policy comes to in each bundled game: the figures of docs/games.json, and a game's as a table."""

import json
from pathlib import Path
from typing import Any

from sjdsl.doc.wording import table
from sjdsl.trainers.policies.estimates import Estimate

# Of a game: `hash` of its rules, `episodes`, `seed`, and `values`: for each name `mean`, `low` and
# `high` (the 95 % interval), each None if the figure isn't defined for every episode.
Figures = dict[str, Any]


def read_figures(path: Path) -> dict[str, Figures]:
    """Returns the figures that a file keeps, by game; none if there is no such file."""
    return json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}


def random_play(figures: Figures) -> list[str]:
    """Returns the lines about a random policy in one game: how it was played, and the table."""
    rows = [(name, _rounded(**figure)) for name, figure in figures["values"].items()]
    return [
        f"A random policy, {figures['episodes']} episodes from seed {figures['seed']}, "
        "means with their 95 % confidence intervals:",
        "",
        *table(("", "mean"), rows),
    ]


def _rounded(mean: float | None, low: float | None, high: float | None) -> str:
    """Returns a cell of the table; of a return or an equality that isn't defined, the reason."""
    if mean is None or low is None or high is None:
        return "not defined: some returns are negative, or all are 0"
    return str(Estimate(mean, low, high))

"""Selects rows of results: games, ways of training, and the seeds behind one figure of a table."""

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, NamedTuple

from sjdsl.library.games_folder import bundled
from sjdsl.results.bundled import rules_now
from sjdsl.results.figures import Result
from sjdsl.results.loading import SETTING
from sjdsl.trainers.runs.stages import FROM_STAGES
from sjdsl.trainers.settings.extensions import short_name

if TYPE_CHECKING:
    import pandas as pd

SHARED = "shared"
APART = "per_agent"
NAMES = {"ippo": "IPPO", "mappo": "MAPPO", "vdn": "VDN"}


class Setting(NamedTuple):
    """A game as it was played: its rules, numbers, map, agents and tasks."""

    game: str
    hash: str
    variant: str
    params: str
    map: str
    num_agents: int
    tasks: str

    @property
    def label(self) -> str:
        """The game, with its differences from the current bundled one."""
        parts = [self.game]
        if self.variant:
            parts.append(f"variant {self.variant}")
        if self.params:
            parts.append(self.params)
        if self.map:
            parts.append(f"map {self.map}")
        if self.tasks not in ("", "training"):
            parts.append(f"tasks {self.tasks}")
        if self.params or self.map:  # they say why the rules are others
            return ", ".join(parts)
        current = rules_now(self.game, self.variant)
        if current is None and self.game in bundled():  # the variant is gone
            parts.append(f"rules {self.hash[:6]}")
        elif current is not None and current[0] != self.hash:
            parts.append(f"rules {self.hash[:6]}")
            if current[1] != self.num_agents:
                parts.append(f"{self.num_agents} agents")
        return ", ".join(parts)


def setting_of(row: Any) -> Setting:
    """Returns the game of a row, as it was played."""
    # Not as attributes: a row of pandas has a method `map`.
    return Setting(**{name: row[name] for name in SETTING})


def seeds_of(frame: "pd.DataFrame") -> "pd.DataFrame":
    """Returns the seeds that are done or failed."""
    return frame[(frame.record == "seed") & (frame.status != "unfinished")]


def games(frame: "pd.DataFrame") -> Iterator[tuple[Setting, "pd.DataFrame"]]:
    """Yields each trained game, as it was played, and the rows of its seeds."""
    for names, rows in seeds_of(frame).groupby([*SETTING], sort=True):
        yield Setting(*names), rows


def select(frame: "pd.DataFrame", **wanted: Any) -> "pd.DataFrame":
    """Returns the rows that have these values in these columns."""
    for name, value in wanted.items():
        frame = frame[frame[name] == value]
    return frame


def result_of(frame: "pd.DataFrame", figure: str = "collective_return") -> Result | None:
    """Returns the result of seeds of one game; None if none have the figure.

    Seeds with different settings are never averaged: of several runs, the result is that of the one
    with the most steps, then the most seeds, then the settings of a preset.
    """
    results = [_result_of_run(rows, figure) for _, rows in frame.groupby("run")]
    return min(
        (result for result in results if result is not None),
        key=lambda result: (-result.steps, -result.seeds, result.preset == "", result.run),
        default=None,
    )


def _result_of_run(rows: "pd.DataFrame", figure: str) -> Result | None:
    """Returns the result of the seeds of one run; None if none have the figure, and none failed."""
    done = rows[rows.status == "done"]
    values = tuple(float(value) for value in done[figure].dropna()) if figure in done else ()
    failed = int((rows.status == "failed").sum())
    if not values and not failed:
        return None
    first = rows.iloc[0]
    return Result(
        run=first.run,
        values=values,
        failed=failed,
        steps=int(rows.steps.max()),
        preset=first.preset,
        hardware=" and ".join(dict.fromkeys(rows.hardware)),
        settings=first.settings,
    )


def in_words(row: Any, sharing: bool = True) -> str:
    """Returns a way of training in words: `IPPO, exchange 0.5`, `IPPO, SVO 45°, weight 0.4`,
    `MAPPO, common, separate parameters`.

    Args:
      row: of a seed.
      sharing: whether to mention separate parameters.
    """
    name = NAMES.get(row.algorithm, short_name(row.algorithm))
    reward, from_stages, _ = str(row.reward).partition(FROM_STAGES)
    if row.algorithm == "vdn":
        return name + from_stages  # VDN always learns from the sum of all rewards
    if reward == "exchange":
        reward_words = f"exchange {row.exchange_ratio:g}"
    elif reward == "svo":
        angle = "several angles" if math.isnan(row.svo_angle) else f"{row.svo_angle:g}°"
        reward_words = f"SVO {angle}, weight {row.svo_weight:g}"
    else:
        reward_words = short_name(reward)
    words = f"{name}, {reward_words}{from_stages}"
    if not sharing or row.sharing == SHARED:
        return words
    if row.sharing == APART:
        return f"{words}, separate parameters"
    return f"{words}, parameters {row.sharing.replace('_', ' ')}"

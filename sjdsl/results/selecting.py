"""Selects rows of results: games, ways of training, and the seeds of a table cell."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, NamedTuple

from sjdsl.library.games_folder import bundled
from sjdsl.results.bundled import rules_now
from sjdsl.results.figures import Cell
from sjdsl.results.loading import SETTING
from sjdsl.trainers.runs.stages import FROM_STAGES
from sjdsl.trainers.settings.extensions import short_name

if TYPE_CHECKING:
    import pandas as pd

SHARED, APART = "shared", "per_agent"
NAMES = {"ippo": "IPPO", "mappo": "MAPPO", "vdn": "VDN"}


class Setting(NamedTuple):
    """A game as it was played: its rules, numbers, map and agents."""

    game: str
    hash: str
    variant: str
    params: str
    map: str
    num_agents: int

    @property
    def label(self) -> str:
        """The game, with its differences from the current bundled one."""
        now = rules_now(self.game, self.variant)
        changed = (
            now[0] != self.hash if now is not None else self.game in bundled()
        )  # a variant that is gone has other rules, too
        other = f"rules {self.hash[:6]}" if changed and not (self.params or self.map) else ""
        agents = (
            f"{self.num_agents} agents"
            if other and now is not None and now[1] != self.num_agents
            else ""
        )
        named = (
            f"variant {self.variant}" if self.variant else "",
            self.params,
            f"map {self.map}" if self.map else "",
        )
        return ", ".join(filter(None, (self.game, *named, other, agents)))


def setting_of(row: Any) -> Setting:
    """Returns the game of a row."""
    return Setting(
        *(row[name] for name in SETTING)
    )  # not as attributes: a row of pandas has a method `map`


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


def cell_of(frame: "pd.DataFrame", figure: str = "collective_return") -> Cell | None:
    """Returns the table cell of seeds of one game; None if none have the figure.

    Seeds with different settings are never averaged: of several runs, the cell is that of the one
    with the most steps, then the most seeds, then the settings of a preset.
    """
    cells = [
        cell for _, rows in frame.groupby("run") if (cell := _of_run(rows, figure)) is not None
    ]
    return min(
        cells,
        key=lambda cell: (-cell.steps, -cell.seeds, cell.preset == "", cell.run),
        default=None,
    )


def _of_run(rows: "pd.DataFrame", figure: str) -> Cell | None:
    done = rows[rows.status == "done"]
    values = tuple(float(value) for value in done[figure].dropna()) if figure in done else ()
    failed = int((rows.status == "failed").sum())
    if not values and not failed:
        return None
    first, hardware = rows.iloc[0], " and ".join(dict.fromkeys(rows.hardware))
    return Cell(
        first.run, values, failed, int(rows.steps.max()), first.preset, hardware, first.settings
    )


def in_words(row: Any, sharing: bool = True) -> str:
    """Returns a way of training in words: `IPPO, exchange 0.5`, `IPPO, SVO 45°, weight 0.4`,
    `MAPPO, common, separate parameters`.

    Args:
      row: of a seed.
      sharing: whether to mention separate parameters.
    """
    name = NAMES.get(row.algorithm, short_name(row.algorithm))
    of_row, from_stages, _ = str(row.reward).partition(FROM_STAGES)
    if row.algorithm == "vdn":
        return name + from_stages  # VDN always learns from the sum of all rewards
    reward = short_name(of_row)
    if of_row == "exchange":
        reward = f"exchange {row.exchange_ratio:g}"
    elif of_row == "svo":
        angle = "several angles" if row.svo_angle != row.svo_angle else f"{row.svo_angle:g}°"
        reward = f"SVO {angle}, weight {row.svo_weight:g}"
    apart = {SHARED: "", APART: ", separate parameters"}.get(
        row.sharing, f", parameters {row.sharing.replace('_', ' ')}"
    )
    return f"{name}, {reward}{from_stages}{apart if sharing else ''}"

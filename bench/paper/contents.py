"""The games on the page of results: those of the paper and others, as they were played, with the
rows of each.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd

from bench.paper import published
from sjdsl.results.bundled import numbers_now, rules_now
from sjdsl.results.figures import Cell
from sjdsl.results.selecting import SHARED, Setting, cell_of, games, seeds_of, select

# Ways of training, by the columns that define them.
Way = Mapping[str, Any]
IPPO: Way = {"algorithm": "ippo", "sharing": SHARED}
INDIVIDUAL: Way = {**IPPO, "reward": "individual"}
COMMON: Way = {**IPPO, "reward": "common"}
MAPPO: Way = {"algorithm": "mappo", "sharing": SHARED, "reward": "common"}
VDN: Way = {"algorithm": "vdn"}
SVO: Way = {**IPPO, "reward": "svo"}
RATIOS = (0.0, 0.25, 0.5, 0.75, 1.0)
PROSOCIAL = 90.0  # degrees, at which weights of SVO are compared


@dataclass(frozen=True)
class Game:
    """A game of the page and the rows of its seeds: no rows if nothing was trained in it under the
    paper's rules.
    """

    name: str
    label: str
    variant: str  # in which it was, or is to be, trained
    setting: Setting | None
    rows: pd.DataFrame
    others: pd.DataFrame  # of the same game and variant, with other numbers

    @property
    def published(self) -> str:
        """The name under which the paper has figures for it; empty unless it has the paper's rules,
        numbers and map.
        """
        plain = self.setting is None or not (self.setting.params or self.setting.map)
        return (
            self.name
            if plain
            and self.name in published.suite()
            and self.variant == published.variant(self.name)
            else ""
        )

    def cell(self, way: Way, figure: str = "collective_return") -> Cell | None:
        """Returns the return of a way of training, or another figure; None if there is none."""
        return cell_of(select(self.rows, **way), figure)

    def like(self, way: str) -> "Game":
        """Returns the game with only the seeds that had the numbers of one way of training, so that
        they can be compared.

        Args:
          way: an algorithm or reward. The released configurations of some set other numbers; what
            was trained with these is in `others`.
        """
        numbers = published.params(self.published, way, way)
        if not numbers:
            return self
        same = [
            published.params(row.game, row.algorithm, row.reward) == numbers
            for row in self.rows.itertuples()
        ]
        more = [_numbers(params) == numbers for params in self.others.params]
        return replace(
            self,
            rows=pd.concat([self.rows[np.array(same, bool)], self.others[np.array(more, bool)]]),
        )

    @property
    def by_weight(self) -> dict[float, Cell]:
        """The cells of SVO at 90 degrees by weight."""
        return _cells(select(self.rows, **SVO, svo_angle=PROSOCIAL), "svo_weight")

    @property
    def by_angle(self) -> tuple[float, dict[float, Cell]]:
        """The SVO weight with the most angles, and its cells by angle."""
        rows = select(self.rows, **SVO)
        rows = rows[rows.svo_angle.notna()]
        if rows.empty:
            return 0.0, {}
        angles = rows.groupby("svo_weight").svo_angle.nunique()
        weight = max(angles.index, key=lambda weight: (angles[weight], weight))
        return float(weight), _cells(rows[rows.svo_weight == weight], "svo_angle")

    @property
    def at_chosen_weight(self) -> tuple[float, Cell | None]:
        """The SVO weight that earns most at 90 degrees, and its cell."""
        cells = self.by_weight
        earned = {
            weight: cell.estimate.mean
            for weight, cell in cells.items()
            if cell.estimate is not None
        }
        weight = max(earned, key=lambda weight: earned[weight], default=0.0)
        return weight, cells.get(weight)

    @property
    def by_ratio(self) -> dict[float, Cell]:
        """The cells of exchanged rewards by ratio, all with the same numbers."""
        same, others = (
            self.like("exchange"),
            self.rows[self.rows.reward == "exchange"].exchange_ratio.dropna(),
        )
        cells = {
            ratio: same.cell(exchanged(ratio)) for ratio in sorted({*RATIOS, *map(float, others)})
        }
        return {ratio: cell for ratio, cell in cells.items() if cell is not None}


def _cells(rows: pd.DataFrame, column: str) -> dict[float, Cell]:
    cells = {float(value): cell_of(own) for value, own in rows.groupby(column)}
    return {value: cell for value, cell in cells.items() if cell is not None}


def exchanged(ratio: float) -> Way:
    """Returns IPPO with exchanged rewards; 0 is individual and 1 common reward, as the protocol
    `exchange` has them.
    """
    return {0.0: INDIVIDUAL, 1.0: COMMON}.get(
        ratio, {**IPPO, "reward": "exchange", "exchange_ratio": ratio}
    )


def under_the_papers_rules(frame: pd.DataFrame) -> pd.DataFrame:
    """Returns the results with those under the paper's rules marked: experiments by their hash,
    runs by the numbers of the released code.

    Numbers that the released configurations set for one way of training in a game count as its
    rules, not as changes. A run that was trained in this way without them shows the numbers that it
    had instead.
    """
    frame = frame.copy()
    for place, row in frame.iterrows():
        theirs = published.variant(row.game)
        if row.record == "seed" and row.variant == theirs:
            wanted = published.params(row.game, row.algorithm, row.reward)
            if _numbers(row.params) == wanted:
                frame.loc[place, "params"] = ""
            elif not row.params:
                now = numbers_now(row.game, theirs)
                frame.loc[place, "params"] = " ".join(
                    f"{name}={now[name]:g}" for name in sorted(wanted)
                )
        elif (
            row.record in ("diagram", "mixture")
            and row.hash == (rules_now(row.game, theirs) or ("",))[0]
        ):
            frame.loc[place, "variant"] = theirs
    return frame


def _numbers(params: str) -> dict[str, float] | None:
    """Returns the numbers of `a=1 b=2e-3` by name; None if a value isn't a number."""
    try:
        return {
            name: float(value) for name, value in (entry.split("=", 1) for entry in params.split())
        }
    except ValueError:
        return None


def games_of(frame: pd.DataFrame) -> list[Game]:
    """Returns the trained games and those of the paper, in its order, then others by name."""
    found = []
    for setting, rows in games(frame):
        same = {name: value for name, value in setting._asdict().items() if name != "params"}
        others = select(seeds_of(frame), **same)
        found.append(
            Game(
                setting.game,
                setting.label,
                setting.variant,
                setting,
                rows,
                others[others.params != setting.params],
            )
        )
    there = {game.published for game in found}
    none = frame.iloc[:0]
    wanted = {name: published.variant(name) for name in published.suite() if name not in there}
    found += [
        Game(name, f"{name}, variant {variant}", variant, None, none, none)
        for name, variant in wanted.items()
    ]
    return sorted(found, key=lambda game: (in_order(game.name), game.label))


def in_order(name: str) -> tuple[int, str]:
    """Returns the sort key of a game: those of the paper in its order, then others by name."""
    suite = published.suite()
    return suite.index(name) if name in suite else len(suite), name

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
from sjdsl.results.figures import Result
from sjdsl.results.selecting import SHARED, Setting, games, result_of, seeds_of, select

# A way of training: the values that columns of the results have for its seeds.
Method = Mapping[str, Any]
IPPO: Method = {"algorithm": "ippo", "sharing": SHARED}
INDIVIDUAL: Method = {**IPPO, "reward": "individual"}
COMMON: Method = {**IPPO, "reward": "common"}
MAPPO: Method = {"algorithm": "mappo", "sharing": SHARED, "reward": "common"}
VDN: Method = {"algorithm": "vdn"}
SVO: Method = {**IPPO, "reward": "svo"}
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
        if self.setting is not None and (self.setting.params or self.setting.map):
            return ""
        if self.name not in published.suite() or self.variant != published.variant(self.name):
            return ""
        return self.name

    def result(self, method: Method, figure: str = "collective_return") -> Result | None:
        """Returns the return of a way of training, or another figure; None without such seeds."""
        return result_of(select(self.rows, **method), figure)

    def with_numbers_of(self, name: str) -> "Game":
        """Returns the game with only the seeds that can be compared with an algorithm or reward:
        those with its numbers.

        The released configurations of some algorithms and rewards set other numbers; what was
        trained with these is in `others`.
        """
        numbers = published.params(self.published, name, name)
        if not numbers:
            return self
        same = [
            published.params(row.game, row.algorithm, row.reward) == numbers
            for row in self.rows.itertuples()
        ]
        same_others = [_read_numbers(params) == numbers for params in self.others.params]
        rows = [self.rows[np.array(same, bool)], self.others[np.array(same_others, bool)]]
        return replace(self, rows=pd.concat(rows))

    @property
    def by_weight(self) -> dict[float, Result]:
        """The results of SVO at 90 degrees by weight."""
        return _results_by(select(self.rows, **SVO, svo_angle=PROSOCIAL), "svo_weight")

    @property
    def by_angle(self) -> tuple[float, dict[float, Result]]:
        """The SVO weight with the most angles, and its results by angle; 0 and none without SVO."""
        rows = select(self.rows, **SVO)
        rows = rows[rows.svo_angle.notna()]
        if rows.empty:
            return 0.0, {}
        angles = rows.groupby("svo_weight").svo_angle.nunique()
        weight = max(angles.index, key=lambda weight: (angles[weight], weight))
        return float(weight), _results_by(rows[rows.svo_weight == weight], "svo_angle")

    @property
    def at_chosen_weight(self) -> tuple[float, Result | None]:
        """The SVO weight that earns most at 90 degrees, and its result.

        Without any mean: weight 0, and its failed result or None.
        """
        results = self.by_weight
        means = {
            weight: result.estimate.mean
            for weight, result in results.items()
            if result.estimate is not None
        }
        weight = max(means, key=lambda weight: means[weight], default=0.0)
        return weight, results.get(weight)

    @property
    def by_ratio(self) -> dict[float, Result]:
        """The results of exchanged rewards by ratio, all with the same numbers."""
        same = self.with_numbers_of("exchange")
        trained = self.rows[self.rows.reward == "exchange"].exchange_ratio.dropna()
        results = {}
        for ratio in sorted({*RATIOS, *map(float, trained)}):
            result = same.result(exchanged(ratio))
            if result is not None:
                results[ratio] = result
        return results


def _results_by(rows: pd.DataFrame, column: str) -> dict[float, Result]:
    """Returns the result of the seeds with each value of a column, where they have one."""
    results = {float(value): result_of(seeds) for value, seeds in rows.groupby(column)}
    return {value: result for value, result in results.items() if result is not None}


def exchanged(ratio: float) -> Method:
    """Returns IPPO with exchanged rewards: 0 is individual and 1 common reward."""
    if ratio == 0:
        return INDIVIDUAL
    if ratio == 1:
        return COMMON
    return {**IPPO, "reward": "exchange", "exchange_ratio": ratio}


def under_the_papers_rules(frame: pd.DataFrame) -> pd.DataFrame:
    """Returns the results with those under the paper's rules marked: experiments by their hash,
    runs by the numbers of the released code.

    Numbers that the released configurations set for one way of training in a game count as its
    rules, not as changes. A run that was trained in this way without them shows the numbers that it
    had instead.
    """
    frame = frame.copy()
    for index, row in frame.iterrows():
        variant = published.variant(row.game)
        if row.record == "seed" and row.variant == variant:
            released = published.params(row.game, row.algorithm, row.reward)
            if _read_numbers(row.params) == released:
                frame.loc[index, "params"] = ""
            elif not row.params:
                usual = numbers_now(row.game, variant)
                numbers = [f"{name}={usual[name]:g}" for name in sorted(released)]
                frame.loc[index, "params"] = " ".join(numbers)
        elif row.record in ("diagram", "mixture"):
            rules = rules_now(row.game, variant)
            if rules is not None and row.hash == rules[0]:
                frame.loc[index, "variant"] = variant
    return frame


def _read_numbers(params: str) -> dict[str, float] | None:
    """Returns the numbers of `a=1 b=2e-3` by name; None if a value isn't a number."""
    try:
        return {
            name: float(value) for name, value in (entry.split("=", 1) for entry in params.split())
        }
    except ValueError:
        return None


def games_of(frame: pd.DataFrame) -> list[Game]:
    """Returns the trained games and those of the paper, in its order, then others by name."""
    all_games = []
    for setting, rows in games(frame):
        same = {name: value for name, value in setting._asdict().items() if name != "params"}
        with_any_numbers = select(seeds_of(frame), **same)
        others = with_any_numbers[with_any_numbers.params != setting.params]
        all_games.append(Game(setting.game, setting.label, setting.variant, setting, rows, others))
    trained = {game.published for game in all_games}
    no_rows = frame.iloc[:0]
    for name in published.suite():
        if name not in trained:
            variant = published.variant(name)
            label = f"{name}, variant {variant}"
            all_games.append(Game(name, label, variant, None, no_rows, no_rows))
    return sorted(all_games, key=lambda game: (sort_key(game.name), game.label))


def sort_key(name: str) -> tuple[int, str]:
    """Returns the sort key of a game: those of the paper in its order, then others by name."""
    suite = published.suite()
    return suite.index(name) if name in suite else len(suite), name

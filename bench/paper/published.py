"""The published figures of the SocialJax paper, typed: `games/published.toml`, where each table has
its source and notes.
"""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

from sjdsl.library.games_folder import games_folder
from sjdsl.results.figures import Figure, number


@dataclass(frozen=True)
class Printed:
    """A published figure; what its deviation is of, and of how many seeds, is not known."""

    mean: float
    deviation: float | None = None

    @property
    def figure(self) -> Figure:
        """As tables show it: `162 ± 3`."""
        if self.deviation is None:
            return Figure(number(self.mean), {"published": self.mean})
        text = f"{number(self.mean)} ± {number(self.deviation)}"
        return Figure(text, {"published": self.mean, "deviation": self.deviation})


@dataclass(frozen=True)
class PaperMetric:
    """The paper's measure of cooperation in a game, and its published values."""

    measure: str  # name of the figure in an evaluation
    scale: float  # by which that figure is multiplied
    per_agent: bool  # divided by the number of agents
    what: str  # what it measures, in words
    printed: Mapping[str, Printed]  # by column


@cache
def _content() -> dict[str, Any]:
    """Returns all tables of the file."""
    return tomllib.loads((games_folder() / "published.toml").read_text(encoding="utf-8"))


def suite() -> tuple[str, ...]:
    """Returns the nine games of the paper."""
    return tuple(_content()["exchange"]["games"])


def variant(game: str) -> str:
    """Returns the variant of a game that the paper played: the rules of its released code."""
    rules = _content()["rules"]
    return str(rules["variants"].get(game, rules["variant"]))


def params(game: str, algorithm: str, reward: str) -> Mapping[str, float]:
    """Returns the numbers that the released configuration of an algorithm or reward sets in a game,
    by name; empty where it sets none.
    """
    entry: dict[str, Any] | None = _content()["rules"]["apart"].get(game)
    if entry is None:
        return {}
    is_set = algorithm in entry["ways"] or reward in entry["ways"]
    return entry["params"] if is_set else {}


def shape(game: str) -> dict[str, str]:
    """Returns `shape`, `type` and `note` of the published Schelling diagram of a game; empty for a
    game that is not of the paper.
    """
    return dict(_content()["schelling"]["games"].get(game, {}))


def exchange(game: str) -> dict[float, Printed]:
    """Returns the published returns by exchange ratio; empty for a game that is not of the
    paper.
    """
    table = _content()["exchange"]
    entry = table["games"].get(game)
    if entry is None:
        return {}
    return {
        ratio: Printed(mean, deviation)
        for ratio, (mean, deviation) in zip(table["ratios"], entry["returns"], strict=True)
    }


def exchange_chosen(game: str) -> float | None:
    """Returns the exchange ratio that the paper chooses (printed in bold); None for a game that is
    not of the paper.
    """
    entry = _content()["exchange"]["games"].get(game)
    return None if entry is None else float(entry["chosen"])


def svo(game: str) -> dict[float, Printed]:
    """Returns the published returns by SVO angle in degrees, summed over agents; empty for a game
    without them.
    """
    table = _content()["svo"]
    entry = table["games"].get(game)
    if entry is None:
        return {}
    return {
        angle: Printed(entry.get("scale", 1) * value)
        for angle, value in zip(table["angles"], entry["returns"], strict=True)
    }


def metric_columns() -> tuple[str, ...]:
    """Returns the ways of training that the metrics table compares."""
    return tuple(_content()["metrics"]["columns"])


def metric(game: str) -> PaperMetric | None:
    """Returns the paper's measure of cooperation in a game; None for one that is not of the
    paper.
    """
    entry = _content()["metrics"]["games"].get(game)
    if entry is None:
        return None
    printed = {
        column: Printed(value)
        for column, value in zip(metric_columns(), entry["values"], strict=True)
    }
    return PaperMetric(
        entry["figure"],
        entry.get("scale", 1),
        entry.get("per_agent", False),
        entry["what"],
        printed,
    )


def difficulty(game: str) -> str:
    """Returns what the paper calls a game: easy to very hard; nothing for another game."""
    entry = _content()["difficulty"]["games"].get(game)
    return "" if entry is None else str(entry["difficulty"])


def speed(game: str, crowd: bool) -> dict[int, float]:
    """Returns the published environment steps a second by number of environments; empty for a game
    without them. crowd: with 20 agents.
    """
    table = _content()["speed"]
    rates = table["games"].get(game, {}).get("crowd" if crowd else "rates")
    return {} if rates is None else dict(zip(table["environments"], rates, strict=True))


def hours(game: str) -> float | None:
    """Returns the published hours to 1e9 environment steps; None for a game without them."""
    entry = _content()["training"]["games"].get(game)
    return None if entry is None else float(entry["hours"])


def melting_pot_speed(game: str) -> float | None:
    """Returns the published environment steps a second of Melting Pot, one environment; None for a
    game without them."""
    rate = _content()["speed"]["games"].get(game, {}).get("one_melting_pot")
    return None if rate is None else float(rate)


def melting_pot_hours(game: str) -> dict[str, float]:
    """Returns the published hours to 1e9 environment steps of Melting Pot, which the paper has
    extrapolated, by what trained in it.
    """
    entry = _content()["training"]["games"].get(game, {})
    names = {
        "melting_pot_stable_baselines3": "Melting Pot with Stable-Baselines3",
        "melting_pot_rllib": "Melting Pot with RLlib",
    }
    return {words: float(entry[name]) for name, words in names.items() if name in entry}


def best_return(game: str) -> float | None:
    """Returns the best published return of a game, over ratios and angles; None for a game that is
    not of the paper.
    """
    means = [printed.mean for printed in (*exchange(game).values(), *svo(game).values())]
    return max(means, default=None)

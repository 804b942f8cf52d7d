"""The statistics of reports against closed forms, published choices and simulation: the 95 % rule, resampling, intervals, Welch."""

import math
from itertools import product
from typing import Any

import numpy as np
import pytest
from report_folders import nearly
from scipy import integrate, special

from sjdsl.report import published
from sjdsl.report.cells import Setting
from sjdsl.report.contents import Game
from sjdsl.report.ninety_five_percent_rule import choice_frequencies, chosen_ratio
from sjdsl.report.sections.over_games import _chosen_games
from sjdsl.report.welch import compare
from sjdsl.trainers.estimates import estimate


@pytest.mark.parametrize("game", published.suite())
def test_the_rule_chooses_what_the_paper_has_in_bold(game: str) -> None:
    assert chosen_ratio({ratio: printed.mean for ratio, printed in published.exchange(game).items()}) == published.exchange_chosen(game)


def test_the_rule_at_its_limits() -> None:
    assert chosen_ratio({}) is None
    assert chosen_ratio({0.0: 0.0, 1.0: 0.0}) is None
    assert chosen_ratio({0.0: -5.0, 1.0: -1.0}) is None
    assert chosen_ratio({0.0: -5.0, 0.5: 95.0, 1.0: 100.0}) == 0.5  # exactly 0.95 of the best is enough
    assert chosen_ratio({0.0: 94.9, 1.0: 100.0}) == 1.0


def test_frequencies_of_two_seeds_in_closed_form() -> None:
    """Of two seeds a and b the mean is a, b or half of both, with 1/4, 1/4 and 1/2: all combinations can be counted."""
    samples = {0.0: (80.0, 100.0), 0.5: (94.0, 97.0), 1.0: (-10.0, 100.0)}
    exact = dict.fromkeys([*samples, None], 0.0)
    means = {ratio: ((a, 0.25), ((a + b) / 2, 0.5), (b, 0.25)) for ratio, (a, b) in samples.items()}
    for drawn in product(*means.values()):
        choice = chosen_ratio(dict(zip(means, (mean for mean, _ in drawn), strict=True)))
        exact[choice] += math.prod(share for _, share in drawn)
    found = choice_frequencies(samples)
    assert nearly(sum(found.values()), 1.0)
    for ratio, share in exact.items():
        assert abs(found[ratio] - share) < 4 * math.sqrt(share * (1 - share) / 10_000) + 1e-9  # four standard errors
    assert min(exact[0.0], exact[0.5]) > 0.1


def test_frequencies_of_nothing_above_zero() -> None:
    assert choice_frequencies({0.0: (-1.0, -2.0), 1.0: (-3.0, 0.0)}) == {0.0: 0.0, 1.0: 0.0, None: 1.0}
    assert choice_frequencies({0.0: (1.0,), 1.0: (2.0,)}) == {0.0: 0.0, 1.0: 1.0, None: 0.0}


def t_quantile(probability: float, freedom: float) -> float:
    """Returns the quantile of Student's t from the inverse of the regularised incomplete beta function."""
    x = special.betaincinv(freedom / 2, 0.5, 2 * (1 - probability))
    return math.sqrt(freedom * (1 - x) / x)


def test_the_interval_in_closed_form() -> None:
    samples = np.array([3.0, 4.0, 8.0])
    found = estimate(samples)
    deviation = math.sqrt(sum((value - 5.0) ** 2 for value in samples) / 2)
    margin = t_quantile(0.975, 2) * deviation / math.sqrt(3)
    assert nearly(found.mean, 5.0)
    assert abs(found.high - (5.0 + margin)) < 1e-9
    assert abs(found.low - (5.0 - margin)) < 1e-9


def test_coverage_of_the_interval() -> None:
    """Of 4,000 sets of five seeds 95 % of the intervals hold the mean, less four standard errors."""
    sets = np.random.default_rng(1).normal(10.0, 3.0, (4000, 5))
    held = sum(found.low <= 10.0 <= found.high for found in map(estimate, sets))
    assert abs(held / 4000 - 0.95) < 4 * math.sqrt(0.95 * 0.05 / 4000)


def density(x: float, freedom: float) -> float:
    log_scale = special.gammaln((freedom + 1) / 2) - special.gammaln(freedom / 2) - math.log(freedom * math.pi) / 2
    return math.exp(log_scale - (freedom + 1) / 2 * math.log1p(x * x / freedom))


def test_welch_in_closed_form() -> None:
    first, second = [10.0, 12.0, 11.0, 15.0], [20.0, 31.0, 27.0]
    spread = [np.var(values, ddof=1) / len(values) for values in (first, second)]
    error = math.sqrt(sum(spread))
    freedom = sum(spread) ** 2 / sum(part**2 / (len(values) - 1) for part, values in zip(spread, (first, second), strict=True))
    found = compare(first, second)
    difference = np.mean(second) - np.mean(first)
    assert nearly(found.difference, difference)
    assert found.low is not None
    assert found.high is not None
    assert found.p is not None
    assert abs(found.low - (difference - t_quantile(0.975, freedom) * error)) < 1e-8
    assert abs(found.high - (difference + t_quantile(0.975, freedom) * error)) < 1e-8
    tail, _ = integrate.quad(density, difference / error, math.inf, args=(freedom,))
    assert abs(found.p - 2 * tail) < 1e-7


def test_welch_without_variance_or_seeds() -> None:
    equal = compare([2.0, 2.0], [2.0, 2.0, 2.0])
    assert (equal.difference, equal.low, equal.high, equal.p) == (0.0, 0.0, 0.0, 1.0)
    apart = compare([2.0, 2.0], [3.0, 3.0])
    assert (apart.difference, apart.low, apart.high, apart.p) == (1.0, 1.0, 1.0, 0.0)
    single = compare([2.0], [3.0, 4.0])
    assert (single.difference, single.low, single.p) == (1.5, None, None)
    with pytest.raises(ValueError, match="a seed of each"):
        compare([], [1.0])


def test_every_table_of_the_paper_is_whole() -> None:
    for game in published.suite():
        assert [*published.exchange(game)] == [0, 0.25, 0.5, 0.75, 1]
        assert [*published.svo(game)] == [0, 22.5, 45, 67.5, 90]
        metric = published.metric(game)
        assert metric is not None
        assert [*metric.printed] == list(published.metric_columns())
        assert [*published.speed(game, crowd=False)] == [1, 128, 1024, 4096]
    assert published.svo("pd_arena")[90].mean == 4 * 53.36
    assert published.best_return("pd_arena") == 260
    assert published.best_return("clean_up") == 1780
    assert published.best_return("orchard") is None
    assert published.hours("coins") == 3
    crowded = [game for game in published.suite() if published.speed(game, crowd=True)]
    assert set(published.suite()) - set(crowded) == {"coins", "pd_arena"}


@pytest.mark.parametrize(
    ("ways", "chosen"),
    [
        (["abcd", "abc", "abc"], "abc"),  # one game more in one way takes no comparison away
        (["abcd", "abcd", "ab", "ab", "ab", "ab"], "ab"),  # twelve pairs rather than eight
        (["abcd", "ab"], "ab"),  # two ways rather than one
        (["abcd"], "abcd"),
        (["ab", "ac"], "ab"),  # as good as each other: the first
        (["ac", "ab"], "ab"),
        (["abc", "bcd"], "bc"),
        (["a", "b"], ""),
        ([], ""),
    ],
)
def test_games_in_which_most_can_be_compared(ways: list[str], chosen: str) -> None:
    found = {f"way {number}": dict.fromkeys(games, np.zeros(2)) for number, games in enumerate(ways)}
    assert _chosen_games("abcd", found) == list(chosen)
    assert _chosen_games("abcd", dict(reversed(found.items()))) == list(chosen)


@pytest.mark.parametrize(
    ("form", "published_as"),
    [
        ({}, ""),
        ({"variant": "socialjax"}, "harvest_open"),
        ({"variant": "crowd", "num_agents": 20}, ""),
        ({"variant": "meltingpot"}, ""),
        ({"params": "apple=2"}, ""),
        ({"map": "other.txt"}, ""),
    ],
)
def test_published_figures_are_of_the_papers_game(form: dict[str, Any], published_as: str) -> None:
    """Nothing published stands beside rules that the paper did not play; `socialjax` has those of its code."""
    plain = {"game": "harvest_open", "hash": "0", "variant": "", "params": "", "map": "", "num_agents": 7}
    assert Game("harvest_open", "any", Setting(**{**plain, **form})).published == published_as

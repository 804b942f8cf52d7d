"""Statistics over games by `rliable`, against figures that can be told without it."""

import itertools
from pathlib import Path

import numpy as np
import pytest

from sjdsl.results.statistics import (
    RESAMPLES,
    draw_profiles,
    improvements,
    interquartile_means,
    probability_of_improvement,
)

# Two seeds, two games; of four scores the interquartile mean leaves out the least and the most.
SCORES = {"low": np.array([[0.0, 0.2], [0.1, 0.9]]), "high": np.array([[1.0, 1.0], [1.0, 1.0]])}


def test_interquartile_means() -> None:
    found = interquartile_means(SCORES)
    assert found["high"] == (1.0, 1.0, 1.0)
    mean, low, high = found["low"]
    assert abs(mean - 0.15) < 1e-12
    # Every resample draws two seeds for each game: all there are can be listed, and hold the interval.
    draws = itertools.product(SCORES["low"][:, 0], repeat=2)
    others = list(itertools.product(SCORES["low"][:, 1], repeat=2))
    means = [np.mean(sorted([*first, *second])[1:3]) for first in draws for second in others]
    assert min(means) - 1e-12 <= low <= mean <= high <= max(means) + 1e-12
    assert low == pytest.approx(np.quantile(means, 0.025), abs=0.06)


def test_improvement_is_of_every_ordered_pair_and_the_same_each_time() -> None:
    found = improvements(SCORES)
    assert set(found) == {("low", "high"), ("high", "low")}
    assert found["high", "low"] == (1.0, 1.0, 1.0)
    assert found["low", "high"][0] == 0.0
    before = np.random.get_state()[1].copy()
    assert interquartile_means(SCORES) == interquartile_means(SCORES)
    assert (
        np.random.get_state()[1] == before
    ).all()  # the resamples are not drawn at anyone's cost


def test_the_probability_of_improvement_is_that_of_rliable() -> None:
    """Also of equal scores, and of tables with other numbers of seeds."""
    from rliable import metrics

    draws = np.random.default_rng(0)
    for _ in range(20):
        first, second = (
            draws.integers(0, 4, (seeds, 5)).astype(float) for seeds in draws.integers(1, 6, 2)
        )
        assert probability_of_improvement(first, second) == pytest.approx(
            metrics.probability_of_improvement(first, second)
        )


@pytest.mark.thorough
def test_profiles_are_drawn(tmp_path: Path) -> None:
    assert RESAMPLES == 2000
    figure = draw_profiles(SCORES)
    lines = figure.axes[0].get_lines()
    assert [line.get_label() for line in lines] == ["low", "high"]
    x, y = lines[0].get_data()
    assert [y[np.searchsorted(x, at)] for at in (0.05, 0.15, 0.5)] == [
        0.75,
        0.5,
        0.25,
    ]  # shares of 0, 0.1, 0.2, 0.9
    figure.savefig(tmp_path / "profiles.svg")

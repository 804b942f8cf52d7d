"""Statistics of results: Welch's test of two cells by SciPy, and figures over games by rliable
(Agarwal et al. 2021).
"""

import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import permutations
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy import stats

from sjdsl.extras import needs
from sjdsl.render.line_plots import MOST
from sjdsl.render.plot_style import Label, line_colour, name_lines, note_below, plot_style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

CONFIDENCE = 0.95
RESAMPLES = 2000
# Of the resamples of each way of training, so that its interval doesn't depend on the others.
SEED = 0
POINTS = 101  # of a performance profile
Interval = tuple[float, float, float]  # the estimate, and the bounds of its 95 % interval
Scores = Mapping[str, np.ndarray]  # way of training -> [seeds, games]


@dataclass(frozen=True)
class Comparison:
    """The difference of two means with its 95 % interval and p-value."""

    difference: float
    low: float | None  # None if one of the two has a single seed
    high: float | None
    p: float | None


def compare(first: Sequence[float], second: Sequence[float]) -> Comparison:
    """Returns the mean of `second` minus the mean of `first`, over the seeds of each.

    If neither varies, the interval has no width and p is 1 or 0, never NaN. Source: Welch 1947, by
    `scipy.stats.ttest_ind`.

    Raises:
      ValueError: one of them has no seed.
    """
    before = np.asarray(first, np.float64)
    after = np.asarray(second, np.float64)
    if before.size == 0 or after.size == 0:
        raise ValueError("a comparison needs at least one seed on each side")
    difference = float(after.mean() - before.mean())
    if before.size < 2 or after.size < 2:
        return Comparison(difference, None, None, None)
    if np.ptp(before) == 0 and np.ptp(after) == 0:
        exact = float(after[0] - before[0])  # the means of equal values may be rounded
        return Comparison(exact, exact, exact, float(exact == 0))
    with warnings.catch_warnings():
        # SciPy warns about a side that hardly varies, which is fine.
        warnings.simplefilter("ignore", RuntimeWarning)
        test = stats.ttest_ind(after, before, equal_var=False)
        bounds = test.confidence_interval(CONFIDENCE)
    return Comparison(difference, float(bounds.low), float(bounds.high), float(test.pvalue))


@contextmanager
def _seeded_rliable() -> Iterator[Any]:
    """Yields rliable's `library` with a fixed seed: it always draws from NumPy's global state."""
    with needs("results"):
        from rliable import library
    state = np.random.get_state()
    np.random.seed(SEED)
    try:
        yield library
    finally:
        np.random.set_state(state)


def _estimate(scores: Any, figure: Callable[..., float]) -> Interval:
    """Returns a figure with its interval from resampling the seeds of each game.

    Args:
      scores: `[seeds, games]`, or a pair of such arrays.
      figure: a function of one or two such arrays.
    """

    def statistic(*resampled: np.ndarray) -> np.ndarray:
        return np.array([figure(*resampled)])

    with _seeded_rliable() as library:
        means, bounds = library.get_interval_estimates({"": scores}, statistic, reps=RESAMPLES)
    low, high = bounds[""]
    return float(means[""][0]), float(low[0]), float(high[0])


def interquartile_means(scores: Scores) -> dict[str, Interval]:
    """Returns the mean of the middle half of the scores of each way of training, over seeds and
    games together.
    """
    return {
        way: _estimate(table, lambda resampled: stats.trim_mean(resampled, 0.25, axis=None))
        for way, table in scores.items()
    }


def improvements(scores: Scores) -> dict[tuple[str, str], Interval]:
    """Returns the probability that a seed of one way of training scores more than one of another,
    averaged over games, by pair.
    """
    return {
        (first, second): _estimate((scores[first], scores[second]), probability_of_improvement)
        for first, second in permutations(scores, 2)
    }


def probability_of_improvement(first: np.ndarray, second: np.ndarray) -> float:
    """Returns the share of pairs of seeds of two `[seeds, games]` tables in which the first has
    more; ties count half.

    It equals `rliable.metrics.probability_of_improvement`, which computes a whole Mann-Whitney test
    for each game: for five ways of training in four games, that took 138 seconds of processor time
    instead of 2.5.
    """
    rows = first[:, None]  # with `columns`, all pairs: [seeds, seeds, games]
    columns = second[None]
    return float(np.mean((rows > columns) + 0.5 * (rows == columns)))


def draw_profiles(scores: Scores) -> "Figure":
    """Returns the share of seeds and games above each score, by way of training, with 95 % bands:
    at most five to a plot.
    """
    from matplotlib.figure import Figure  # here: importing it costs as much as a short test

    flat = np.concatenate([table.ravel() for table in scores.values()])
    scale = np.linspace(min(0.0, float(flat.min())), max(1.0, float(flat.max())), POINTS)
    groups = [list(scores)[first : first + MOST] for first in range(0, len(scores), MOST)]
    colour = {way: line_colour(number) for number, way in enumerate(scores)}
    with plot_style():
        figure = Figure(figsize=(max(7.0, 5.6 * len(groups)), 3.8), layout="constrained")
        for index, group in enumerate(groups, 1):
            axes = figure.add_subplot(1, len(groups), index)
            labels = []
            for way in group:
                with _seeded_rliable() as library:
                    profile, band = library.create_performance_profile(
                        {way: scores[way]}, scale, reps=RESAMPLES
                    )
                axes.plot(scale, profile[way], color=colour[way], label=way)
                axes.fill_between(scale, *band[way], color=colour[way], alpha=0.2, linewidth=0)
                # Labels are at the means, as all lines end near 0.
                labels.append(Label(way, float(profile[way].mean()), colour[way]))
            axes.set(xlabel="score", ylabel="share of seeds and games above it", ylim=(0, 1.02))
            name_lines(axes, labels)
        note_below(figure, "Bands: 95 % intervals.")
    return figure

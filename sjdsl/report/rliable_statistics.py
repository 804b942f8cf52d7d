"""Statistics over games by the library `rliable` (Agarwal et al. 2021), which is an extra; one of its figures is computed faster here."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from importlib.util import find_spec
from itertools import permutations
from typing import TYPE_CHECKING, Any

import numpy as np

from sjdsl.report.drawing import colours
from sjdsl.trainers.panels import MOST

if TYPE_CHECKING:
    from matplotlib.figure import Figure

INSTALL = "This section takes the extra `results`: install it with `pip install 'sjdsl[results]'` and make the report again."
RESAMPLES = 2000
SEED = 0  # of the resamples of each way of training: the same scores have the same intervals, whatever stands beside them
POINTS = 101  # of a performance profile
Interval = tuple[float, float, float]  # the estimate, and the bounds of its 95 % interval
Scores = Mapping[str, np.ndarray]  # way of training -> [seeds, games]


def is_installed() -> bool:
    """Returns whether the extra is there."""
    return find_spec("rliable") is not None


@contextmanager
def _seeded() -> Iterator[None]:
    """Has `rliable` draw the same resamples each time: it draws from NumPy's global state, whatever it is given."""
    before = np.random.get_state()
    np.random.seed(SEED)
    try:
        yield
    finally:
        np.random.set_state(before)


def interquartile_means(scores: Scores) -> dict[str, Interval]:
    """Returns the interquartile mean of each way of training, with its interval by stratified bootstrap."""
    from rliable import library, metrics

    intervals = {}
    for way, table in scores.items():
        with _seeded():
            means, bounds = library.get_interval_estimates(
                {way: table}, lambda drawn: np.array([metrics.aggregate_iqm(drawn)]), reps=RESAMPLES
            )
        intervals[way] = _interval(means[way], bounds[way])
    return intervals


def improvements(scores: Scores) -> dict[tuple[str, str], Interval]:
    """Returns the probability that a seed of one way of training has more than one of another, on average over games, by pair."""
    from rliable import library

    intervals = {}
    for first, second in permutations(scores, 2):
        with _seeded():
            means, bounds = library.get_interval_estimates(
                {"": (scores[first], scores[second])}, probability_of_improvement, reps=RESAMPLES
            )
        intervals[first, second] = _interval(means[""], bounds[""])
    return intervals


def probability_of_improvement(first: np.ndarray, second: np.ndarray) -> float:
    """Returns in how many pairs of a seed of `[seeds, games]` and of another such table the first has more; equal ones count half.

    It is `rliable.metrics.probability_of_improvement`, which makes SciPy's Mann-Whitney test of each game and takes of it only this share.
    With the resamples of five ways of training in four games that took 138 seconds of processor time, and this takes 2.5.
    """
    one, other = first[:, None], second[None]
    return float(np.mean((one > other) + 0.5 * (one == other)))


def _interval(mean: Any, bounds: Any) -> Interval:
    return float(np.ravel(mean)[0]), float(np.ravel(bounds[0])[0]), float(np.ravel(bounds[1])[0])


def draw_profiles(scores: Scores) -> "Figure":
    """Returns the share of seeds and games above each score, by way of training, with 95 % bands: at most five to a plot."""
    from matplotlib.figure import Figure  # here: importing it costs as much as a short test
    from rliable import library

    flat = np.concatenate([table.ravel() for table in scores.values()])
    scale = np.linspace(min(0.0, float(flat.min())), max(1.0, float(flat.max())), POINTS)
    profiles: dict[str, np.ndarray] = {}
    bands: dict[str, np.ndarray] = {}
    for way, table in scores.items():
        with _seeded():
            of_way, band_of_way = library.create_performance_profile({way: table}, scale, reps=RESAMPLES)
        profiles |= of_way
        bands |= band_of_way
    groups = [list(scores)[first : first + MOST] for first in range(0, len(scores), MOST)]
    figure = Figure(figsize=(max(7.0, 5.0 * len(groups)), 3.8), layout="constrained")
    with colours():
        for number, group in enumerate(groups, 1):
            axes = figure.add_subplot(1, len(groups), number)
            for way in group:
                (line,) = axes.plot(scale, profiles[way], label=way)
                axes.fill_between(scale, *bands[way], color=line.get_color(), alpha=0.2, linewidth=0)
            axes.set(xlabel="score", ylabel="share of seeds and games above it")
            axes.grid(alpha=0.3)
            axes.legend(fontsize="small")
    return figure

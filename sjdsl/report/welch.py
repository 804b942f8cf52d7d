"""Compares two cells of ours: the difference of their means by Welch's t-test, which lets their variances differ."""

import warnings
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats

CONFIDENCE = 0.95


@dataclass(frozen=True)
class Comparison:
    """The difference of two means with its 95 % interval, and the probability of one at least as large were there none."""

    difference: float
    low: float | None  # None where one of the two has a single seed
    high: float | None
    p: float | None


def compare(first: Sequence[float], second: Sequence[float]) -> Comparison:
    """Returns how much more `second` has than `first`, on average over the seeds of each.

    Where neither varies the interval has no width, and p is 1 or 0: never NaN. Source: Welch 1947, by `scipy.stats.ttest_ind`.

    Raises:
      ValueError: one of them has no seed.
    """
    before, after = np.asarray(first, np.float64), np.asarray(second, np.float64)
    if not (before.size and after.size):
        raise ValueError("a comparison needs a seed of each of the two")
    difference = float(after.mean() - before.mean())
    if before.size < 2 or after.size < 2:
        return Comparison(difference, None, None, None)
    if np.ptp(before) == 0 == np.ptp(after):
        exact = float(after[0] - before[0])  # the means of equal values may be rounded
        return Comparison(exact, exact, exact, float(exact == 0))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # that one of them hardly varies is no reason to doubt the other's spread
        test = stats.ttest_ind(after, before, equal_var=False)
        bounds = test.confidence_interval(CONFIDENCE)
    return Comparison(difference, float(bounds.low), float(bounds.high), float(test.pvalue))

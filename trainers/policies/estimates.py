"""Estimates a mean from a few samples, by Student's t."""

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from scipy import stats

DIGITS = 2  # of half the width of an interval, when it is printed
NO_WIDTH = 1e-6  # of its bounds: half a width that only rounding can have made


@dataclass(frozen=True)
class Estimate:
    """A mean over samples (episodes, or training seeds) and its confidence interval."""

    mean: float
    low: float
    high: float

    def __str__(self) -> str:
        """Returns `11.0 [8.9, 13.1]`: rounded to two digits of half the interval's width.

        A figure that some sample doesn't define has no mean; a single sample has no bounds.
        """
        if math.isnan(self.mean):
            return "not defined"
        if not math.isfinite(self.high - self.low):
            return f"{number(self.mean)} [not known]"
        margin = (self.high - self.low) / 2
        if margin <= NO_WIDTH * max(abs(self.low), abs(self.high)):
            mean, low, high = map(number, (self.mean, self.low, self.high))
        else:
            decimals = max(0, DIGITS - 1 - math.floor(math.log10(margin)))
            mean, low, high = (
                f"{value:z,.{decimals}f}" for value in (self.mean, self.low, self.high)
            )
        return f"{mean} [{low}, {high}]"


def number(value: float) -> str:
    """Returns a number with at most four significant digits: `0.91`, `163.2`, `1,780`."""
    if abs(value) >= 1000:
        return f"{value:,.0f}"
    return f"{value:z.4g}"


def stack_estimates(
    estimates: Iterable[Estimate],
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Returns the means, the lower and the upper bounds of P estimates, `[P]` float64 each."""
    rows = [(figure.mean, figure.low, figure.high) for figure in estimates]
    mean, low, high = np.array(rows, np.float64).reshape(-1, 3).T
    return mean, low, high


def estimate(samples: np.ndarray, confidence: float = 0.95) -> Estimate:
    """Returns the mean of `[E]` samples and its interval by Student's t.

    It is infinitely wide for one sample, and of width 0 if all are equal.
    """
    samples = np.asarray(samples, np.float64)
    if len(samples) < 2:
        return Estimate(float(samples.mean()), -math.inf, math.inf)
    first = float(samples[0])
    if (samples == first).all():  # rounding would change their mean, and give them a deviation
        return Estimate(first, first, first)
    mean = float(samples.mean())
    low, high = stats.t.interval(confidence, len(samples) - 1, mean, stats.sem(samples))
    return Estimate(mean, float(low), float(high))


def difference(first: np.ndarray, second: np.ndarray, confidence: float = 0.95) -> Estimate:
    """Returns the mean of some samples minus that of others, with Welch's interval.

    It is infinitely wide if one has fewer than two samples, and of width 0 if neither varies.
    Source: Welch, "The generalization of 'Student's' problem when several different population
    variances are involved", Biometrika 34, 1947.
    """
    first = np.asarray(first, np.float64)
    second = np.asarray(second, np.float64)
    mean = float(first.mean() - second.mean())
    if min(len(first), len(second)) < 2:
        return Estimate(mean, -math.inf, math.inf)
    if np.ptp(first) == np.ptp(second) == 0:
        return Estimate(mean, mean, mean)
    welch = stats.ttest_ind(first, second, equal_var=False)
    low, high = welch.confidence_interval(confidence)
    return Estimate(mean, float(low), float(high))

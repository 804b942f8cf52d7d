"""Estimates a mean from a few samples, by Student's t."""

import math
from dataclasses import dataclass

import numpy as np
from scipy import stats


@dataclass(frozen=True)
class Estimate:
    """A mean over samples (episodes, or training seeds) and its confidence interval."""

    mean: float
    low: float
    high: float


def estimate(samples: np.ndarray, confidence: float = 0.95) -> Estimate:
    """Returns the mean of `[E]` samples and its interval by Student's t.

    It is infinitely wide for one sample, and of width 0 if all are equal.
    """
    samples = np.asarray(samples, np.float64)
    if len(samples) < 2:
        return Estimate(float(samples.mean()), -math.inf, math.inf)
    if (
        samples == samples[0]
    ).all():  # rounding would change their mean, and give them a small standard deviation
        return Estimate(float(samples[0]), float(samples[0]), float(samples[0]))
    mean = float(samples.mean())
    margin = half_width(float(samples.std(ddof=1)), len(samples), confidence)
    return Estimate(mean, mean - margin, mean + margin)


def half_width(deviation: float, number: int, confidence: float) -> float:
    """Returns half the width of the interval of two or more samples with a standard deviation."""
    return float(stats.t.ppf(0.5 + confidence / 2, number - 1) * deviation / math.sqrt(number))

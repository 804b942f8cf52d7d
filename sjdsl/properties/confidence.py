"""Confidence intervals for episode statistics: Clopper and Pearson for shares, Student's t for means."""

import math
from collections.abc import Sequence

CONFIDENCE = 0.95
# Two-sided 95% quantiles of Student's t for 1 .. 30 degrees of freedom. Source: any table of the distribution.
T = (
    12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228, 2.201, 2.179, 2.160, 2.145, 2.131,
    2.120, 2.110, 2.101, 2.093, 2.086, 2.080, 2.074, 2.069, 2.064, 2.060, 2.056, 2.052, 2.048, 2.045, 2.042,
)  # fmt: skip


def least_share(trials: int) -> float:
    """Returns the 95% lower confidence bound of a probability of success after so many trials, all of them successes; exact.

    Source: Clopper and Pearson 1934, one-sided, all trials successes: share^n = 5%.
    """
    return math.pow(1 - CONFIDENCE, 1 / trials)


def mean_and_half(values: Sequence[float]) -> tuple[float, float]:
    """Returns the mean over episodes and half of its 95% confidence interval (Student's t: approximate, as episodes are not normal)."""
    n = len(values)
    mean = sum(values) / n
    if n < 2:
        return mean, math.inf
    variance = sum((v - mean) ** 2 for v in values) / (n - 1)
    return mean, T[min(n - 1, len(T)) - 1] * math.sqrt(variance / n)

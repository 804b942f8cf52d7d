"""Chi-square tests with a stated false alarm, and how small a bias each of them finds.

Seeds are fixed, so a test that passes passes always; the false alarm is the probability that it would have failed on the day it was
written, by chance alone. A bias is told as w = sqrt(sum((q - p)^2 / p)), p the right probabilities, q the wrong ones: of two equally
likely outcomes 0.5 + d and 0.5 - d, w is 2 d. Source: Cohen, "Statistical power analysis for the behavioral sciences", 1988, ch. 7.
"""

from collections.abc import Sequence
from functools import cache

import numpy as np
from scipy import optimize, stats

FALSE_ALARM = 1e-6
POWER = 0.999
FEWEST = 20  # expected in each class: there the chi-square distribution may be used


def assert_distribution(
    counts: np.ndarray, probabilities: Sequence[float] | None, finds: float, tests: int = 1
) -> None:
    """Asserts how often each outcome came; equally often without `probabilities`. `finds`: a bias that the test finds at least."""
    counts = np.asarray(counts, np.float64).reshape(-1)
    shares = (
        np.full(counts.size, 1 / counts.size)
        if probabilities is None
        else np.asarray(probabilities, np.float64)
    )
    assert abs(shares.sum() - 1) < 1e-9
    expected = shares * counts.sum()
    assert expected.min() >= FEWEST, "too few trials"
    _judge(
        float(((counts - expected) ** 2 / expected).sum()),
        counts.size - 1,
        counts.sum(),
        finds,
        tests,
        counts,
    )


def assert_independent(table: np.ndarray, finds: float, tests: int = 1) -> None:
    """Asserts that rows and columns of a table of counts have nothing to do with one another."""
    table = np.asarray(table, np.float64)
    table = table[table.sum(axis=1) > 0][:, table.sum(axis=0) > 0]
    expected = table.sum(axis=1, keepdims=True) * table.sum(axis=0, keepdims=True) / table.sum()
    assert min(table.shape) > 1, "an outcome that is always the same"
    assert expected.min() >= FEWEST, "too few trials"
    freedom = (table.shape[0] - 1) * (table.shape[1] - 1)
    _judge(
        float(((table - expected) ** 2 / expected).sum()), freedom, table.sum(), finds, tests, table
    )


@cache
def found_bias(trials: float, freedom: int, tests: int = 1) -> float:
    """Returns the w that is found with probability `POWER`."""
    bound = stats.chi2.isf(FALSE_ALARM / tests, freedom)
    largest = 10 * (bound + 100)
    return float(
        np.sqrt(
            optimize.brentq(lambda x: stats.ncx2.sf(bound, freedom, x) - POWER, 1e-3, largest)
            / trials
        )
    )


def _judge(
    statistic: float, freedom: int, trials: float, finds: float, tests: int, counts: np.ndarray
) -> None:
    assert found_bias(trials, freedom, tests) <= finds, (
        f"finds a bias of {found_bias(trials, freedom, tests):.4f} only"
    )
    chance = float(stats.chi2.sf(statistic, freedom))
    assert chance >= FALSE_ALARM / tests, (
        f"as likely as {chance:.1e}: chi-square {statistic:.1f}, {freedom} degrees: {counts.tolist()}"
    )

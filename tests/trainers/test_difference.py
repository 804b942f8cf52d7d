"""The difference of two means, with Welch's interval."""

import math

import numpy as np
import pytest

from sjdsl.trainers.policies.estimates import difference


def test_interval_is_that_of_welch() -> None:
    """Variances 2.5 and 10 of five samples each: a standard error of sqrt(2.5), and
    2.5^2 / (0.5^2 / 4 + 2^2 / 4) = 5.882 degrees of freedom, for which tables have 2.45 at 97.5 %
    (2.447 for 6, 2.571 for 5)."""
    first = np.array([5.0, 6.0, 7.0, 8.0, 9.0])
    second = np.array([1.0, 3.0, 5.0, 7.0, 9.0])
    found = difference(first, second)
    assert found.mean == 2
    quantile = (found.high - found.mean) / math.sqrt(2.5)
    assert 2.447 < quantile < 2.571
    assert found.high - found.mean == pytest.approx(found.mean - found.low)


def test_few_samples_and_equal_ones() -> None:
    one = np.array([3.0])
    same = np.array([1.0, 1.0])
    assert difference(one, same).low == -math.inf
    assert difference(same + 1, same) == difference(np.array([2.0, 2.0]), same)
    assert (difference(same + 1, same).low, difference(same + 1, same).high) == (1, 1)

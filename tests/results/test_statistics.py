"""The statistics of reports against closed forms and simulation: intervals, and Welch's test."""

import math

import numpy as np
import pytest
from report_folders import nearly
from scipy import integrate, special

from sjdsl.results.figures import Result, differing_settings
from sjdsl.results.statistics import compare


def t_quantile(probability: float, freedom: float) -> float:
    """Returns the quantile of Student's t from the inverse of the regularised incomplete beta function."""
    x = special.betaincinv(freedom / 2, 0.5, 2 * (1 - probability))
    return math.sqrt(freedom * (1 - x) / x)


def density(x: float, freedom: float) -> float:
    log_scale = (
        special.gammaln((freedom + 1) / 2)
        - special.gammaln(freedom / 2)
        - math.log(freedom * math.pi) / 2
    )
    return math.exp(log_scale - (freedom + 1) / 2 * math.log1p(x * x / freedom))


def test_welch_in_closed_form() -> None:
    first, second = [10.0, 12.0, 11.0, 15.0], [20.0, 31.0, 27.0]
    spread = [np.var(values, ddof=1) / len(values) for values in (first, second)]
    error = math.sqrt(sum(spread))
    freedom = sum(spread) ** 2 / sum(
        part**2 / (len(values) - 1) for part, values in zip(spread, (first, second), strict=True)
    )
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
    with pytest.raises(ValueError, match="at least one seed on each side"):
        compare([], [1.0])


def test_settings_in_which_columns_differ_are_named() -> None:
    def trained(settings: str) -> Result:
        return Result("run", (1.0, 2.0), 0, 400, "", "cpu", settings)

    results = {
        "individual": trained('{"num_envs": 8}'),
        "common": trained('{"init_from": "a policy"}'),
        "vdn": None,
    }
    assert differing_settings(results) == [
        "the seeds of common started from a trained policy; those of individual didn't.",
        "`num_envs` is 8 in individual; the default in common.",
    ]

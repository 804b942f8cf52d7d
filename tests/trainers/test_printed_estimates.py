"""Printed estimates: as many digits as their intervals warrant."""

import math

import numpy as np
import pytest

from sjdsl.trainers.policies.estimates import Estimate, estimate


@pytest.mark.parametrize(
    ("mean", "margin", "text"),
    [
        (10.98234, 2.1041, "11.0 [8.9, 13.1]"),
        (163.21, 3.14159, "163.2 [160.1, 166.4]"),
        (1.667, 12.75, "2 [-11, 14]"),
        (0.97234, 0.0625, "0.972 [0.910, 1.035]"),
        (1508.4, 230.7, "1,508 [1,278, 1,739]"),
        (0.00012345, 0.0000101, "0.000123 [0.000113, 0.000134]"),
        (-0.3, 40.0, "0 [-40, 40]"),
        (0.7, 0.0996, "0.700 [0.600, 0.800]"),
        (1000.0, 0.0, "1,000 [1,000, 1,000]"),
        (0.123456, 0.0, "0.1235 [0.1235, 0.1235]"),
        (0.123456, 1e-12, "0.1235 [0.1235, 0.1235]"),
        (math.nan, math.nan, "not defined"),
        (12.3456, math.inf, "12.35 [not known]"),
    ],
)
def test_a_figure_is_rounded_to_its_interval(mean: float, margin: float, text: str) -> None:
    assert str(Estimate(mean, mean - margin, mean + margin)) == text


def test_one_sample_has_no_interval() -> None:
    assert str(estimate(np.array([2.0]))) == "2 [not known]"

"""Where a trajectory violates a check, written down by hand; and the confidence bound against its definition."""

from typing import Any

import pytest

from sjdsl.compiler import ir
from sjdsl.properties.monitors import Violation, find_violation, least_share

T, F = True, False
TRAJECTORIES: list[tuple[str, list[Any], Violation | None]] = [
    ("always", [F, T, T], None),  # the start is no step
    ("always", [T, T, F], Violation(2)),
    ("once", [(T, F), (F, F), (F, F)], None),
    ("once", [(F, F), (T, T), (F, T)], None),
    ("once", [(F, F), (T, T), (F, F)], Violation(2, 1)),
    ("once", [(F, F), (T, F), (F, T)], Violation(1, 1)),
    ("conserved", [3, 3, 3], None),
    ("conserved", [3, 4, 3], Violation(1, 0)),
    ("conserved", ["red", "red", "green"], Violation(2, 0)),
    ("conserved", [1000.0, 1000.01], None),  # what sums of float32 lose
    ("conserved", [1000.0, 1001.0], Violation(1, 0)),
    ("monotone falling", [(5, 0), (4, 1), (4, 2), (5, 0)], None),
    ("monotone falling", [(5, 1), (4, 0)], Violation(1, 0)),
    ("monotone rising", [(5, 1), (4, 0), (9, 0.5)], Violation(2, 0)),
    ("monotone rising", [(5, 1), (4, 1)], None),  # an equal argument says nothing
]


@pytest.mark.parametrize(("check", "values", "wanted"), TRAJECTORIES)
def test_violations(check: str, values: list[Any], wanted: Violation | None) -> None:
    sort, *words = check.split()
    rows = [row if isinstance(row, tuple) else (row,) for row in values]
    assert find_violation(ir.Check(kind=sort, words=tuple(words)), rows) == wanted  # type: ignore[arg-type]


@pytest.mark.parametrize("trials", [1, 3, 30, 1000])
def test_a_share_that_small_would_have_been_noticed(trials: int) -> None:
    """With a share just below the bound, all trials succeed in less than one case of twenty; with a larger one in more."""
    share = least_share(trials)
    assert (share - 1e-6) ** trials < 0.05 < (share + 1e-6) ** trials

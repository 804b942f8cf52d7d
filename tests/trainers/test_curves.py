"""Learning curves of several runs: which numbers are drawn."""

import json
from pathlib import Path

import numpy as np
import pytest

from sjdsl.trainers import RunError
from sjdsl.trainers.curves import column, draw_curves, read_seeds

ROWS = [
    {"update": 1, "env_steps": 10, "collective_return": None, "event_own_agent_0": None, "event_own_agent_1": None, "event_other": None},
    {"update": 2, "env_steps": 20, "collective_return": 4.0, "event_own_agent_0": 1.0, "event_own_agent_1": 2.0, "event_other": 1.0},
    {"update": 3, "env_steps": 30, "collective_return": 6.0, "event_own_agent_0": 3.0, "event_own_agent_1": 3.0, "event_other": 2.0},
]


@pytest.mark.parametrize(
    ("metric", "values"),
    [
        ("collective_return", [np.nan, 4, 6]),
        ("event_own", [np.nan, 3, 6]),
        ("event_own_agent_1", [np.nan, 2, 3]),
        ("event_own+event_other", [np.nan, 4, 8]),
        ("event_own/event_own+event_other", [np.nan, 0.75, 0.75]),
    ],
)
def test_a_metric_may_be_a_sum_or_a_share(metric: str, values: list[float]) -> None:
    np.testing.assert_array_equal(column(ROWS, metric), values)


def test_an_unknown_metric_is_told_with_those_there_are() -> None:
    with pytest.raises(RunError, match="no column `event_none`; they have update, env_steps, collective_return"):
        column(ROWS, "event_none")


def test_runs_of_several_seeds_are_drawn(tmp_path: Path) -> None:
    for seed in (0, 1):
        (tmp_path / "run" / f"seed_{seed}").mkdir(parents=True)
        (tmp_path / "run" / f"seed_{seed}" / "metrics.jsonl").write_text("".join(json.dumps(row) + "\n" for row in ROWS))
    with pytest.raises(RunError, match="is no folder of a run"):
        read_seeds(tmp_path / "run")
    (tmp_path / "run" / "manifest.json").write_text(json.dumps({"game": {}, "config": {}, "versions": {}}))
    assert [len(rows) for rows in read_seeds(tmp_path / "run")] == [3, 3]
    draw_curves([("a", tmp_path / "run")], "collective_return", tmp_path / "curve.png")
    assert (tmp_path / "curve.png").read_bytes().startswith(b"\x89PNG")

"""Learning curves of several runs: which numbers are drawn."""

import json
from pathlib import Path

import numpy as np
import pytest

from sjdsl.trainers import RunError
from sjdsl.trainers.runs.curves import curve_line, draw_curves, figures, read_seeds
from sjdsl.trainers.runs.learning_curve import curve_panels
from sjdsl.trainers.runs.metrics_files import known_row

ROWS = [
    {
        "update": 1,
        "env_steps": 10,
        "collective_return": None,
        "event_own_agent_0": None,
        "event_own_agent_1": None,
        "event_other": None,
    },
    {
        "update": 2,
        "env_steps": 20,
        "collective_return": 4.0,
        "event_own_agent_0": 1.0,
        "event_own_agent_1": 2.0,
        "event_other": 1.0,
    },
    {
        "update": 3,
        "env_steps": 30,
        "collective_return": 6.0,
        "event_own_agent_0": 3.0,
        "event_own_agent_1": 3.0,
        "event_other": 2.0,
    },
]


@pytest.mark.parametrize(
    ("metric", "values"),
    [
        ("collective_return", [np.nan, 4, 6]),
        ("event_own", [np.nan, 3, 6]),
        ("event_own_agent_1", [np.nan, 2, 3]),
    ],
)
def test_a_metric_is_a_column_or_the_sum_over_agents(metric: str, values: list[float]) -> None:
    np.testing.assert_array_equal(figures(map(known_row, ROWS), metric), [[10, 20, 30], values])


def test_an_unknown_metric_is_told_with_those_there_are() -> None:
    with pytest.raises(
        RunError, match="no column `event_none`; they have update, env_steps, collective_return"
    ):
        figures(map(known_row, ROWS), "event_none")


def test_runs_of_several_seeds_are_drawn(tmp_path: Path) -> None:
    for seed in (0, 1):
        (tmp_path / "run" / f"seed_{seed}").mkdir(parents=True)
        (tmp_path / "run" / f"seed_{seed}" / "metrics.jsonl").write_text(
            "".join(json.dumps(row) + "\n" for row in ROWS)
        )
    with pytest.raises(RunError, match="is not the folder of a training run"):
        read_seeds(tmp_path / "run", "collective_return")
    (tmp_path / "run" / "manifest.json").write_text(
        json.dumps({"game": {}, "config": {}, "versions": {}})
    )
    assert [seed.shape for seed in read_seeds(tmp_path / "run", "collective_return")] == [
        (2, 3),
        (2, 3),
    ]
    draw_curves([("a", tmp_path / "run")], "collective_return", tmp_path / "curve.png")
    assert (tmp_path / "curve.png").read_bytes().startswith(b"\x89PNG")


def test_agents_stand_beside_the_return_of_all() -> None:
    agents = {f"return_agent_{number}": 1.0 for number in range(7)}
    rows = [{"env_steps": 10, "episodes": 0, "collective_return": np.nan, **agents}]
    assert curve_panels(rows) == []
    rows.append({"env_steps": 20, "episodes": 2, "collective_return": 7.0, **agents})
    panels = curve_panels(rows)
    assert [panel.title for panel in panels] == [
        "all agents together",
        "agent 0 to agent 3",
        "agent 4 to agent 6",
    ]
    assert panels[0].lines[0].steps.tolist() == [20], "where an episode has ended"
    assert [
        panel.title
        for panel in curve_panels(
            [{key: rows[1][key] for key in ("env_steps", "episodes", "collective_return")}]
        )
    ] == ["all agents together"]


def test_a_run_without_values_is_no_curve(tmp_path: Path) -> None:
    (tmp_path / "manifest.json").write_text(json.dumps({"game": {}, "config": {}, "versions": {}}))
    (tmp_path / "metrics.jsonl").write_text(json.dumps(ROWS[0]) + "\n")
    with pytest.raises(
        RunError, match=r"there is no curve to draw\. Perhaps no episode ended in the run"
    ):
        curve_line("a", tmp_path, "collective_return")

"""The JSON of marl-eval against the structure that its README documents."""

import json
from pathlib import Path
from typing import Any

from report_folders import read, write_run

from sjdsl.results.marl_eval import marl_eval


def check_structure(data: dict[str, Any]) -> list[tuple[str, str, str]]:
    """Returns task, algorithm and run of each run, having checked: environment -> task -> algorithm -> run -> steps, then the absolute metrics."""
    found = []
    for tasks in data.values():
        for task, algorithms in tasks.items():
            for algorithm, runs in algorithms.items():
                for name, steps in runs.items():
                    *numbered, last = steps
                    assert last == "absolute_metrics"
                    assert numbered == [f"step_{number}" for number in range(1, len(numbered) + 1)]
                    metrics = set(steps[last])
                    counts = []
                    for step in numbered:
                        entry = dict(steps[step])
                        counts.append(entry.pop("step_count"))
                        assert isinstance(counts[-1], int)
                        assert set(entry) == metrics
                        assert all(isinstance(values, list) and len(values) == 1 for values in entry.values())
                    assert counts == sorted(set(counts))
                    assert all(isinstance(values, list) and len(values) in (1, 10) for values in steps[last].values())
                    found.append((task, algorithm, name))
    return found


def test_the_documented_structure(tmp_path: Path) -> None:
    write_run(tmp_path / "shared", "coins", (158.0, 154.5, 160.0), reward="common")
    write_run(tmp_path / "half", "coins", (None, 90.0), diverged=(0,), reward="exchange")
    write_run(tmp_path / "going_on", "harvest_open", (None, None), status="running")
    found = read(tmp_path)
    data, _ = marl_eval(found.frame, found.curves)
    assert [*data] == ["sjdsl"]
    assert check_structure(data) == [("coins", "IPPO, common", f"seed_{seed}") for seed in range(3)]  # a seed of the other has failed
    seed = data["sjdsl"]["coins"]["IPPO, common"]["seed_0"]
    assert seed["step_3"] == {"step_count": 400, "return": [158.0]}
    assert seed["absolute_metrics"] == {"return": [158.0]}
    json.dumps(data)


def test_what_marl_eval_will_not_take_is_said(tmp_path: Path) -> None:
    def told() -> list[str]:
        found = read(tmp_path)
        return marl_eval(found.frame, found.curves)[1]

    for game in ("coins", "pd_arena"):
        write_run(tmp_path / game, game, (1.0, 2.0))
    assert told() == []
    write_run(tmp_path / "more", "coins", (3.0,), first=2)
    assert "equally many seeds" in told()[0]
    write_run(tmp_path / "other", "coins", (3.0,), reward="common")
    assert "the same ways of training" in told()[0]

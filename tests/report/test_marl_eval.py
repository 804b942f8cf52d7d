"""The JSON of marl-eval against the structure that its README documents."""

import json
from pathlib import Path
from typing import Any

from report_folders import write_run

from sjdsl.report import read_folders
from sjdsl.report.contents import contents_of
from sjdsl.report.marl_eval import marl_eval


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


def test_the_documented_structure(written: Path) -> None:
    data = json.loads((written / "marl_eval.json").read_text())
    assert [*data] == ["sjdsl"]
    found = check_structure(data)
    assert ("coins, variant socialjax", "IPPO, common", "seed_2") in found
    assert not any(way == "IPPO, exchange 0.25" for _, way, _ in found)  # a seed of it has failed
    assert not any(task == "harvest_open" and "learning" in way for task, way, _ in found)
    coins = data["sjdsl"]["coins, variant socialjax"]["IPPO, common"]["seed_0"]
    assert coins["step_3"] == {"step_count": 400, "return": [158.0]}
    assert coins["absolute_metrics"] == {"return": [158.0]}


def test_what_marl_eval_will_not_take_is_said(tmp_path: Path) -> None:
    runs = [write_run(tmp_path / game, game, (1.0, 2.0)) for game in ("coins", "pd_arena")]
    assert marl_eval(contents_of(read_folders(runs), whole_suite=False))[1] == []
    third = write_run(tmp_path / "more", "coins", (3.0,), first=2)
    assert "equally many seeds" in marl_eval(contents_of(read_folders([*runs, third]), whole_suite=False))[1][0]
    other = write_run(tmp_path / "other", "coins", (3.0,), reward="common")
    assert "the same ways of training" in marl_eval(contents_of(read_folders([*runs, other]), whole_suite=False))[1][0]

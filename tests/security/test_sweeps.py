"""The folder of a sweep from elsewhere: it leads to no other folder, and to no code that the caller has not named."""

import json
from pathlib import Path
from typing import Any

import pytest

from sjdsl.experiments.refusals import ExperimentError
from sjdsl.results import ResultsError, load
from sjdsl.sweeps import SweepSpec, run_cell
from sjdsl.sweeps.axes import read_axis
from sjdsl.sweeps.folder import (
    cells_of,
    describe_sweep,
    merge_sweep,
    progress_of,
    read_sweep,
    write_sweep,
)
from sjdsl.sweeps.plan import plan_sweep
from sjdsl.sweeps.running import describe_with_make
from sjdsl.sweeps.tables import results
from sjdsl.trainers.settings.extensions import NotAllowed

STRANGE = [None, True, -1, 0.5, 10**400, "x", "\udcff", [], {}, [[]], [5], {"a": 1}]


@pytest.fixture(scope="module")
def asked() -> dict[str, Any]:
    """What `sweep.json` says of a sweep of two cells."""
    wanted = SweepSpec(
        ("coins",), [read_axis("reward=individual,common")], {"total_timesteps": 64}, episodes=1
    )
    return json.loads(json.dumps(describe_sweep(wanted, plan_sweep(wanted, describe_with_make))))


def put(folder: Path, content: Any) -> None:
    (folder / "sweep.json").write_text(json.dumps(content))


@pytest.mark.parametrize(
    "name",
    ["../victim", "..", ".", "/tmp", "a/../../victim", "a*", "a\0", "a\n", "", "\udcff", "a" * 300],
)
def test_a_cell_is_named_by_no_path(name: str, asked: dict[str, Any], tmp_path: Path) -> None:
    cell = next(iter(asked["cells"].values()))
    put(tmp_path, {**asked, "cells": {**asked["cells"], name: cell}})
    for read in (read_sweep, lambda folder: merge_sweep(folder, asked)):
        with pytest.raises(
            ExperimentError,
            match=r"not 1, for in `cells\.|damaged and can't be read|no readable sweep\.json",
        ):
            read(tmp_path)
    if "/" in name:
        with pytest.raises(ResultsError, match="named by a path"):
            load(tmp_path)


def test_code_that_only_the_folder_names_does_not_run(
    asked: dict[str, Any], tmp_path: Path
) -> None:
    code = tmp_path / "theirs.py"
    code.write_text(
        "from pathlib import Path\nPath(__file__).with_suffix('.ran').touch()\ndef reward(step):\n    return step.reward\n"
    )
    changed = json.loads(json.dumps(asked))
    name, cell = next(iter(changed["cells"].items()))
    cell["config"]["reward"] = f"{code}:reward"
    put(tmp_path, changed)
    known = write_sweep(
        tmp_path,
        {
            **asked,
            "cells": {other: asked["cells"][other] for other in asked["cells"] if other != name},
        },
    )
    assert results(tmp_path, known) == []
    assert [cell.name for cell in cells_of(read_sweep(tmp_path))] == list(asked["cells"])
    with pytest.raises(
        NotAllowed, match=r"the cell .* of a sweep names a reward of your own, .*--allow-code"
    ):
        run_cell(tmp_path / "cells" / name)
    assert not code.with_suffix(".ran").exists()


def test_whatever_stands_in_its_file_is_a_message(asked: dict[str, Any], tmp_path: Path) -> None:
    name = next(iter(asked["cells"]))
    places = (
        [(key,) for key in asked]
        + [("cells", name)]
        + [("cells", name, key) for key in asked["cells"][name]]
    )
    for place in places:
        for value in STRANGE:
            changed = json.loads(json.dumps(asked))
            inner = changed
            for key in place[:-1]:
                inner = inner[key]
            inner[place[-1]] = value
            put(tmp_path, changed)
            try:
                known = read_sweep(tmp_path)
            except ExperimentError:
                continue
            for cell in cells_of(known):
                assert progress_of(tmp_path, cell, known["episodes"]).state == "waiting"
            assert len(cells_of(known)) == len(known["cells"])
            try:
                merge_sweep(tmp_path, asked)
            except ExperimentError:
                continue

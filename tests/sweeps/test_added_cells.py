"""New values of its axes add cells to a sweep, and so do other axes and another game."""

from pathlib import Path
from typing import Any

import pytest

from sjdsl.sweeps.axes import read_axis
from sjdsl.sweeps.cells import SweepSpec
from sjdsl.sweeps.folder import describe_sweep, write_sweep
from sjdsl.sweeps.plan import plan_sweep
from tests.sweeps.described import describe


def add(folder: Path, axis: str, game: str = "coins", **changes: Any) -> set[str]:
    """Adds a sweep's cells to a folder; returns the names of all it has."""
    settings = {"seeds": 2, **changes.pop("settings", {})}
    spec = SweepSpec([game], [read_axis(axis)], settings, **changes)
    return {*write_sweep(folder, describe_sweep(spec, plan_sweep(spec, describe)))["cells"]}


@pytest.mark.parametrize(
    ("before", "now", "changes"),
    [
        ("variant=meltingpot", "variant=crowd", {}),
        ("param.apple=1", "param.apple=2", {"params": {"regrow": {"red": 0.1, "blue": 0.2}}}),
        ("algorithm=ippo", "algorithm=mappo", {"preset": "two_cores", "settings": {"seed": 3}}),
        ("reward=individual", "reward=svo", {"preset": "paper"}),
        ("gamma=0.9", "learning_rate=0.1", {}),
    ],
)
def test_new_values_with_all_else_as_it_was(
    tmp_path: Path, before: str, now: str, changes: dict[str, Any]
) -> None:
    first = add(tmp_path, before, **changes)
    assert first < add(tmp_path, now, **changes)


def test_another_game_may_have_settings_of_its_own(tmp_path: Path) -> None:
    add(tmp_path, "gamma=0.9")
    assert len(add(tmp_path, "gamma=0.9", game="clean_up", settings={"num_envs": 8})) == 2

"""What may be added to a sweep: cells that the same command would have made from the beginning, with the game's file as it was."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from sjdsl.experiments.refusals import ExperimentError
from sjdsl.sweeps.axes import read_axis
from sjdsl.sweeps.cells import SweepSpec
from sjdsl.sweeps.folder import describe_sweep, merged, write_sweep
from sjdsl.sweeps.plan import plan_sweep
from tests.sweeps.described import describe


def add(folder: Path, axis: str, rules: str = "", game: str = "coins", protocol: str | None = None, **changes: Any) -> set[str]:
    """Adds a sweep's cells to a folder; returns the names of all it has. `rules`: what the game's file says now."""

    def described(game: str, variant: str | None, params: Mapping[str, Any]) -> tuple[dict[str, Any], str, str]:
        if rules == f"no {variant}":
            raise ValueError("the game has no such variant")
        provenance, name, digest = describe(game, variant, params)
        return provenance, name, digest + rules

    settings = {"seeds": 2, **changes.pop("settings", {})}
    plan = plan_sweep(SweepSpec([game], [read_axis(axis)] if axis else [], protocol, settings, **changes), described)
    wanted = describe_sweep(plan.spec, plan.cells)
    merged(folder, wanted, plan)
    return {*write_sweep(folder, wanted)["cells"]}


@pytest.mark.parametrize(
    ("before", "now", "changes"),
    [
        ("variant=meltingpot", "variant=crowd", {}),
        ("param.apple=1", "param.apple=2", {"params": {"regrow": {"red": 0.1, "blue": 0.2}}}),
        ("algorithm=ippo", "algorithm=mappo", {"preset": "two_cores", "settings": {"seed": 3}}),
        ("reward=individual", "reward=svo", {"preset": "paper"}),
        ("gamma=0.9", "gamma=0.99", {"protocol": "svo"}),
    ],
)
def test_new_values_with_all_else_as_it_was(tmp_path: Path, before: str, now: str, changes: dict[str, Any]) -> None:
    first = add(tmp_path, before, **changes)
    assert first < add(tmp_path, now, **changes)


@pytest.mark.parametrize(
    ("before", "now", "changes", "said"),
    [
        (
            "variant=meltingpot",
            "variant=crowd",
            {"rules": " changed"},
            "hash of the game coins-meltingpot there, coins-meltingpot changed here",
        ),
        (
            "variant=meltingpot",
            "variant=crowd",
            {"rules": "no meltingpot"},
            "its cell coins_variant-meltingpot can't be made any more: coins with variant meltingpot: the game has no",
        ),
        ("param.apple=1", "param.apple=2", {"params": {"regrow": 0.2}}, "params of the game regrow None there, 0.2 here"),
        ("param.apple=1", "param.apple=2", {"game": "mine/coins.sj"}, "game of the game coins there, mine/coins.sj here"),
        ("algorithm=ippo", "algorithm=mappo", {"preset": "two_cores"}, "total_timesteps 10000000 there, 3000000 here"),
        ("algorithm=ippo", "algorithm=vdn", {"settings": {"seeds": 5}}, "its cell coins_algorithm-ippo has seeds 2 there, 5 here"),
        ("gamma=0.9", "gamma=0.99", {"settings": {"seed": 7}}, "its cell coins_gamma-0.9 has seed 0 there, 7 here"),
    ],
)
def test_new_values_with_something_else(tmp_path: Path, before: str, now: str, changes: dict[str, Any], said: str) -> None:
    add(tmp_path, before)
    kept = (tmp_path / "sweep.json").read_bytes()
    with pytest.raises(ExperimentError, match="holds another sweep") as refused:
        add(tmp_path, now, **changes)
    assert said in str(refused.value)
    assert str(refused.value).endswith("the games' files included, or name another folder")
    assert (tmp_path / "sweep.json").read_bytes() == kept


def test_another_game_may_have_settings_of_its_own(tmp_path: Path) -> None:
    add(tmp_path, "gamma=0.9")
    assert len(add(tmp_path, "gamma=0.9", game="clean_up", settings={"num_envs": 8})) == 2

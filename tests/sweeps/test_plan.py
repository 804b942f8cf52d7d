"""From axes to cells: names, configurations, seeds, and what is refused."""

import re
from pathlib import Path
from typing import Any

import pytest

from sjdsl.experiments.refusals import ExperimentError
from sjdsl.sweeps.axes import read_axis, with_number
from sjdsl.trainers import register
from tests.sweeps.described import plan


def test_a_value_is_one_however_it_is_written() -> None:
    (cell,) = plan("exchange_ratio=.50", settings={"reward": "exchange"})
    assert cell.values == {"exchange_ratio": 0.5}
    assert cell.name == "coins_exchange_ratio-0.5"
    (cell,) = plan("total_timesteps=1e3")
    assert cell.values == {"total_timesteps": 1000}


def test_values_with_commas_stand_in_brackets() -> None:
    axis = read_axis('param.regrow=[0.1,0.2],{"red":0.5,"blue":[1]}')
    assert axis.values == ("[0.1,0.2]", '{"red":0.5,"blue":[1]}')
    first, second = plan("svo_angle=[45,90],[0,90]", settings={"reward": "svo"})
    assert first.values == {"svo_angle": [45.0, 90.0]}
    assert second.config["svo_angle"] == [0.0, 90.0]


def test_entries_of_tables() -> None:
    assert with_number({"a": 1}, "regrow[red]", 2) == {"a": 1, "regrow": {"red": 2}}
    assert with_number({"regrow": {"blue": 1}}, "regrow[red]", 2) == {
        "regrow": {"blue": 1, "red": 2}
    }
    (cell,) = plan("param.regrow[red][x]=0.1")
    assert cell.provenance["params"] == {"regrow": {"red": {"x": 0.1}}}
    assert re.fullmatch(r"[\w.-]+", cell.name)


def test_presets_lay_their_tables_under_each_cell() -> None:
    """`paper` has another learning schedule for the reward svo than for the others, and another seed than 0."""
    own, other = plan("reward=individual,svo", preset="paper")
    assert own.config["anneal_learning_rate"] is True
    assert other.config["anneal_learning_rate"] is False
    assert own.seeds == range(30, 32)


def learner(env: Any, config: Any, *, bonus: float = 0.5) -> None:
    """An algorithm that is never made."""


def test_settings_of_ones_own_on_axes() -> None:
    register("algorithm", "mine", learner)
    first, second = plan("own.bonus=.10,2", settings={"algorithm": "mine"})
    assert (first.name, first.values, first.config["own"]) == (
        "coins_own.bonus-0.1",
        {"own.bonus": 0.1},
        {"bonus": 0.1},
    )
    assert second.config["own"] == {"bonus": 2}
    for settings in ({"own.bonus": "3"}, {"own": {"bonus": 3}}):  # of those cells that take it
        ippo, mine = plan("algorithm=ippo,mine", settings=settings)
        assert (ippo.config["own"], mine.config["own"], mine.configuration().own) == (
            {},
            {"bonus": 3},
            (("bonus", 3),),
        )
        with pytest.raises(ExperimentError, match=r"`own\.bonus` does nothing in any cell"):
            plan("algorithm=ippo,mappo", settings=settings)
    with pytest.raises(
        ExperimentError,
        match=r"coins with own\.bonos 1: `own\.bonos` does nothing: .*; did you mean `bonus`\?",
    ):
        plan("own.bonos=1", settings={"algorithm": "mine"})
    with pytest.raises(
        ExperimentError, match=r"`own\.bonus` is an axis, and is also set for all cells"
    ):
        plan("own.bonus=1,2", settings={"algorithm": "mine", "own": {"bonus": 1}})


def test_a_setting_of_all_cells_is_for_those_that_read_it() -> None:
    own, exchanged = plan(
        "reward=individual,exchange", settings={"exchange_ratio": 0.9}, preset="two_cores"
    )
    assert (own.config["exchange_ratio"], exchanged.config["exchange_ratio"]) == (0.5, 0.9)
    for preset in (None, "two_cores"):
        ippo, vdn = plan(
            "algorithm=ippo,vdn",
            settings={"clip_epsilon": 0.3, "layer_norm": True, "reward": "common"},
            preset=preset,
        )
        assert (ippo.config["clip_epsilon"], vdn.config["layer_norm"]) == (0.3, True)
        assert "layer_norm" not in ippo.config and "clip_epsilon" not in vdn.config


def test_what_no_command_line_can_ask_for_is_refused() -> None:
    """What one can is in `tests/cli/refused.txt`."""
    with pytest.raises(ExperimentError, match="name the games to train in"):
        plan("reward=common", games=())
    with pytest.raises(ExperimentError, match="10,001 cells, and 10,000 are the most"):
        plan(f"learning_rate={','.join(map(str, range(1, 10_002)))}")


def of_tasks(cell: Any) -> dict[str, Any]:
    """Returns the arguments of a cell's environment that choose its tasks."""
    names = ("tasks", "split", "problem")
    return {name: cell.provenance[name] for name in names if name in cell.provenance}


def test_tasks_are_axes_or_the_same_in_all_cells() -> None:
    all_tasks, red, three = plan("tasks=all,hue=red,pay[red]=3")
    assert of_tasks(all_tasks) == {"tasks": "all"}
    assert of_tasks(red) == {"tasks": {"hue": "red"}}
    assert of_tasks(three) == {"tasks": {"pay": {"red": 3}}}
    assert [red.name, three.name] == ["coins_tasks-hue-red", "coins_tasks-pay-red-3"]
    (cell,) = plan("problem=7", tasks="held_out", split="late")
    assert of_tasks(cell) == {"tasks": "held_out", "split": "late", "problem": 7}
    assert cell.values == {"problem": 7}
    with pytest.raises(ExperimentError, match="`tasks` is an axis, and is also set for all cells"):
        plan("tasks=all", tasks="training")


def test_a_choice_of_tasks_replaces_that_of_a_preset(tmp_path: Path) -> None:
    preset = tmp_path / "mine.toml"
    preset.write_text('[environment]\ntasks = "held_out"\nsplit = "late"\n')
    kept, *_ = plan("learning_rate=1", preset=str(preset))
    assert of_tasks(kept) == {"tasks": "held_out", "split": "late"}
    replaced, *_ = plan("problem=7", preset=str(preset))
    assert of_tasks(replaced) == {"problem": 7}

"""What a report reads of each kind of folder, and what it says of folders that are half written, failed, of other rules, or of no kind."""

import json
from pathlib import Path
from typing import Any

import pandas as pd
import pytest
from report_folders import (
    Found,
    read,
    write_cross_play,
    write_diagram,
    write_json,
    write_run,
    write_sweep,
)
from report_folders import described as describe

import sjdsl
from sjdsl.results import ResultsError, load, load_curves
from sjdsl.results.bundled import other_numbers
from sjdsl.results.loading import COLUMNS, POINTS, columns_of_run, load_both, write_frame
from sjdsl.results.selecting import in_words
from sjdsl.results.settings import column_of

NONE = pytest.approx(float("nan"), nan_ok=True)
DIAGRAM = {
    "A": (60.0, 50.0, 70.0),
    "B": (5.0, 1.0, 9.0),
    "fear": (-4.0, -5.0, -3.0),
    "greed": (2.0, 1.0, 3.0),
}


def earned(found: Found) -> dict[int, float | None]:
    """Returns the returns of the seeds; None where there is none."""
    return {
        row.seed: None if pd.isna(row.collective_return) else row.collective_return
        for row in found.rows("seed")
    }


def test_a_run(tmp_path: Path) -> None:
    folder = write_run(
        tmp_path / "run",
        "coins",
        (3.0, 5.0),
        first=4,
        measures={"event own_coins": (7.0, 8.0)},
        reward="exchange",
        exchange_ratio=0.25,
    )
    found = read(folder)
    run, _ = found.rows("seed")
    assert (run.game, run.algorithm, run.reward, run.exchange_ratio, run.sharing) == (
        "coins",
        "ippo",
        "exchange",
        0.25,
        "shared",
    )
    assert earned(found) == {4: 3.0, 5: 5.0}
    assert [(row.steps, row.episodes, row.hardware, row.status) for row in found.rows("seed")] == [
        (400, 30, "cpu", "done")
    ] * 2
    assert found.frame["event own_coins"].to_list() == [7.0, 8.0]
    assert "return of agent 0" not in found.frame
    assert [
        (row.env_steps, row.collective_return) for row in found.curves.itertuples() if row.seed == 4
    ] == [
        (200, 1.5),
        (300, 2.25),
        (400, 3.0),
    ]
    assert found.notes == ()


def test_actions_that_were_chosen_otherwise_are_no_result(tmp_path: Path) -> None:
    """`sjdsl evaluate --greedy` of a policy that draws its actions writes in the same place."""
    folder = write_run(tmp_path / "run", "coins", (3.0, 5.0))
    file = folder / "seed_1/evaluation.json"
    file.write_text(json.dumps(json.loads(file.read_text()) | {"greedy": True}))
    found = read(folder)
    assert earned(found) == {0: 3.0, 1: None}
    assert found.notes == (
        f"`{folder}` isn't evaluated, or only with `--greedy` or `--drawn`: run `sjdsl evaluate {folder}`",
    )


def test_seeds_of_one_way_of_training_are_taken_together_from_several_folders(
    tmp_path: Path,
) -> None:
    folders = [
        write_run(tmp_path / "a", "coins", (3.0, 5.0)),
        write_run(tmp_path / "b", "coins", (4.0,), first=2),
    ]
    together = read(*folders)
    assert together.frame.run.nunique() == 1
    assert earned(together) == {0: 3.0, 1: 5.0, 2: 4.0}
    others = [
        write_run(tmp_path / "c", "coins", (4.0,), learning_rate=0.5),
        write_run(tmp_path / "d", "coins", (4.0,), rules="other"),
    ]
    assert read(*folders, *others).frame.run.nunique() == 3


def test_what_is_found_twice_is_taken_from_the_later_one(tmp_path: Path) -> None:
    first, second = (
        write_run(tmp_path / "a", "coins", (3.0,)),
        write_run(tmp_path / "b", "coins", (9.0,)),
    )
    found = read(first, second)
    assert earned(found) == {0: 9.0}
    assert found.curves.collective_return.to_list() == [4.5, 6.75, 9.0]
    assert "found twice with different figures" in found.notes[0]
    assert read(first, first).notes == ()
    stopped = write_run(tmp_path / "c", "coins", (9.0,), status="interrupted")
    assert earned(read(first, stopped)) == {0: 3.0}


def test_a_half_written_run_is_left_out_and_says_how_it_goes_on(tmp_path: Path) -> None:
    going, ended = (
        write_run(tmp_path / status, "coins", (3.0,), status=status)
        for status in ("running", "interrupted")
    )
    for folder, how in ((going, "isn't finished"), (ended, "ended early (interrupted)")):
        found = read(folder)
        assert [row.status for row in found.rows("seed")] == ["unfinished"]
        assert found.curves.empty
        assert how in found.notes[0]
        assert f"sjdsl train --resume {folder}" in found.notes[0]
    (going / "manifest.json").write_text("{half")
    assert "has no readable manifest.json" in read(going).notes[0]


def test_a_run_that_is_not_evaluated(tmp_path: Path) -> None:
    folder = write_run(tmp_path / "run", "coins", (None, None))
    found = read(folder)
    assert earned(found) == {0: None, 1: None}
    assert f"sjdsl evaluate {folder}" in found.notes[0]
    assert len(found.curves) == 6
    write_json(folder / "seed_0/evaluation.json", {"summary": "half"})
    assert earned(read(folder)) == {0: None, 1: None}


def test_a_seed_that_has_failed(tmp_path: Path) -> None:
    found = read(write_run(tmp_path / "run", "coins", (1.0, 2.0), diverged=[1]))
    assert [(row.seed, row.status) for row in found.rows("seed")] == [(0, "done"), (1, "failed")]
    assert set(found.curves.seed) == {0}
    assert "seed 1" in found.notes[0]
    several = read(
        write_run(
            tmp_path / "several", "coins", (1.0, 2.0, 3.0, 4.0), diverged=[0, 1, 3], reward="common"
        )
    )
    assert several.notes == (
        f"seeds 0, 1 and 3 of `{tmp_path / 'several'}` diverged (non-finite loss): this run has no mean",
    )
    alone = read(
        write_run(
            tmp_path / "alone", "coins", (1.0,), status="failed: the loss became nan", diverged=[0]
        )
    )
    assert [row.status for row in alone.rows("seed")] == ["failed"]


def test_metrics_that_were_cut_off_and_long_ones(tmp_path: Path) -> None:
    folder = write_run(tmp_path / "run", "coins", (4.0,))
    metrics = folder / "metrics.jsonl"
    metrics.write_text(metrics.read_text() + '{"update": 5, "env_st')
    assert len(load_curves(folder)) == 3
    many = [f'{{"env_steps": {100 * n}, "collective_return": {n}}}\n' for n in range(1, 1001)]
    metrics.write_text("".join(many))
    points = load_curves(folder)
    assert len(points) == POINTS
    assert tuple(points.loc[0, ["env_steps", "collective_return"]]) == (
        2500,
        13.0,
    )  # updates 1 to 25
    assert points.env_steps.max() == 100_000


def test_numbers_of_a_run_that_was_started_from_python(tmp_path: Path) -> None:
    folder = write_run(tmp_path / "run", "coins", (3.0,))
    manifest = json.loads((folder / "manifest.json").read_text())
    manifest["provenance"] = {}
    manifest["game"]["params"] = {
        "length": 1000,
        "spawn": 0.0005000000237487257,
        "coin": 1.0,
        "harm": -2.0,
    }  # as float32 has them
    write_json(folder / "manifest.json", manifest)
    assert read(folder).frame.params[0] == ""
    manifest["game"]["params"] |= {"harm": -3.0, "length": 100}
    write_json(folder / "manifest.json", manifest)
    assert read(folder).frame.params[0] == "harm=-3.0 length=100"
    crowd = write_run(
        tmp_path / "crowd",
        "harvest_open",
        (3.0,),
        provenance={"num_agents": 3, "params": {"regrow_1": 0}},
    )
    assert read(crowd).frame.params[0] == "num_agents=3 regrow_1=0"


def test_a_sweep(tmp_path: Path) -> None:
    sweep = tmp_path / "sweep"
    write_run(sweep / "cells/individual", "coins", (20.0, 21.0))
    write_run(sweep / "cells/common", "coins", (100.0, 101.0), reward="common")
    write_sweep(sweep, ["individual", "common", "late", "bad"], failed=["bad"])
    found = read(sweep)
    assert sorted(row.collective_return for row in found.rows("seed")) == [20, 21, 100, 101]
    assert found.notes == (
        f"2 cells of the sweep `{sweep}` are not trained yet",
        f"the cell `bad` of the sweep `{sweep}` has failed",
    )


def test_experiments(tmp_path: Path) -> None:
    write_diagram(tmp_path / "diagram", "coins", DIAGRAM, "dilemma", notes=["seed 1 is left out"])
    write_cross_play(
        tmp_path / "met", "coins", {"random": (-0.5, None, None), "stay": (0.0, 0.0, 0.0)}
    )
    found = read(tmp_path)  # a folder of folders
    (row,) = found.rows("diagram")
    assert (row.outcome, row.fear, row.greed, row.A_low, row.greed_high) == (
        "dilemma",
        False,
        True,
        50.0,
        3.0,
    )
    assert found.notes == ("seed 1 is left out",)
    assert [(row.policy, row["mean"], row.low) for row in found.rows("mixture")] == [
        ("random", -0.5, NONE),
        ("stay", 0.0, 0.0),
    ]
    assert [(row.collective_return, row.low) for row in found.rows("random")] == [
        (-1.0, NONE)
    ]  # of both agents together


def test_numbers_that_a_variant_sets_are_not_other_numbers() -> None:
    released = {"name": "coop_mining", "hash": sjdsl.make("coop_mining", variant="socialjax").hash}
    assert (
        other_numbers({**released, "params": {"spawn_iron": 0.0002, "spawn_gold": 0.00008}}) == []
    )
    assert other_numbers({**released, "params": {"spawn_iron": 0.0004, "spawn_gold": 0.00008}}) == [
        "spawn_iron=0.0004"
    ]


def test_an_experiment_that_is_not_finished(tmp_path: Path) -> None:
    for name in ("schelling", "crossplay"):
        write_json(tmp_path / name / "experiment.json", {"experiment": name})
        assert "isn't finished" in read(tmp_path / name).notes[0]


def test_what_is_written_is_read_again(tmp_path: Path) -> None:
    write_run(
        tmp_path / "runs/a",
        "coins",
        (1.23456789, -2.0),
        measures={"event own_coins": (1 / 3, 2e9)},
        reward="svo",
    )
    write_run(
        tmp_path / "runs/b",
        "coins",
        (None,),
        reward="svo",
        svo_angle=(45, 90),
        provenance={"params": {"harm": -3}, "map": ["AB"]},
    )
    write_diagram(tmp_path / "runs/d", "coins", DIAGRAM, "dilemma")
    write_cross_play(tmp_path / "runs/m", "coins", {"random": (-0.5, None, None)})
    found, curves = load_both([tmp_path / "runs"])
    data = tmp_path / "data"
    data.mkdir()
    (data / "results.csv").write_text(write_frame(found))
    (data / "curves.csv").write_text(write_frame(curves))
    for folders in ([data], [data, tmp_path / "runs"]):
        for again, before in zip(load_both(folders), (found, curves), strict=True):
            pd.testing.assert_frame_equal(
                again.drop(columns="folder"), before.drop(columns="folder")
            )
    (data / "results.csv").write_text((data / "results.csv").read_text().replace("done", "well"))
    with pytest.raises(
        ResultsError, match=r"results.csv: `status` is done, failed or unfinished, not `well`"
    ):
        load(data)
    (data / "results.csv").write_text(
        (data / "results.csv").read_text().replace(",400,cpu", ",many,cpu")
    )
    with pytest.raises(ResultsError, match=r"results.csv cannot be read \(ValueError"):
        load(data)
    (data / "results.csv").write_text("seed,run\n")
    with pytest.raises(ResultsError, match=r"results\.csv lacks the columns "):
        load(data)


def test_texts_that_look_like_numbers_stay_texts(tmp_path: Path) -> None:
    """Also a hash of digits alone, and a game called NA."""
    found = pd.DataFrame(
        [{"record": "random", "game": "NA", "hash": "1234567890123456", "collective_return": 1.0}],
        columns=COLUMNS,
    )
    (tmp_path / "results.csv").write_text(write_frame(found))
    assert load(tmp_path)[["game", "hash"]].to_numpy().tolist() == [["NA", "1234567890123456"]]


def test_what_is_nothing_that_a_report_is_made_of(tmp_path: Path) -> None:
    with pytest.raises(ResultsError, match="there is no folder or file"):
        read(tmp_path / "nowhere")
    with pytest.raises(ResultsError, match="holds no results; name the folder of a run, a sweep"):
        read(tmp_path)
    write_json(tmp_path / "other.json", [1])
    with pytest.raises(ResultsError, match="holds no results"):
        read(tmp_path / "other.json")


def test_a_run_in_stages_is_marked(tmp_path: Path) -> None:
    """Its steps are those of all stages, its curve goes on over them, and it doesn't stand for the same reward from scratch."""
    scratch = write_run(tmp_path / "scratch", "coins", (3.0,), reward="common")
    write_run(tmp_path / "run", "coins", (8.0,), reward="common")
    write_run(tmp_path / "run/stages/1", "coins", (5.0,), reward="individual", num_envs=20)
    lines = [json.loads(line) for line in (tmp_path / "run/metrics.jsonl").read_text().splitlines()]
    steps_before = 4 * 2 * 100
    (tmp_path / "run/metrics.jsonl").write_text(
        "".join(
            json.dumps(line | {"env_steps": line["env_steps"] + steps_before}) + "\n"
            for line in lines
        )
    )
    found = load_both([scratch, tmp_path / "run"])
    frame = found[0].set_index("reward")
    assert set(frame.index) == {"common", "common from stages"}
    staged = frame.loc["common from stages"]
    assert (staged.steps, staged.collective_return, staged.preset) == (steps_before + 400, 8.0, "")
    (stage,) = json.loads(staged.settings)["stages"]
    assert (stage["reward"], stage["num_envs"], stage["num_agents"]) == (
        "individual",
        20,
        staged.num_agents,
    )
    assert staged.run != frame.loc["common"].run
    points = found[1][found[1].run == staged.run]
    assert points.env_steps.is_monotonic_increasing
    assert points.env_steps.max() == steps_before + 400
    assert {in_words(row) for _, row in found[0].iterrows()} == {
        "IPPO, common",
        "IPPO, common from stages",
    }
    manifest = json.loads((tmp_path / "run/stages/1/manifest.json").read_text())
    assert columns_of_run(manifest | {"stage": 1})["reward"] == "individual"
    assert columns_of_run(manifest | {"stage": 2})["reward"] == "individual from stages"


# Settings in which runs differ.


def columns_of(frame: pd.DataFrame) -> list[str]:
    """Returns the columns of settings, between two that are always there."""
    names = list(frame)
    return names[names.index("settings") + 1 : names.index("preset")]


def test_a_swept_setting_is_a_column_with_its_type(tmp_path: Path) -> None:
    ways: list[dict[str, Any]] = [
        {
            "learning_rate": 1e-3,
            "num_envs": 10,
            "anneal_learning_rate": True,
            "memory": "none",
            "convolution_sides": [5, 3],
            "network": "cnn",
        },
        {
            "learning_rate": 5e-4,
            "num_envs": 20,
            "anneal_learning_rate": False,
            "memory": "gru",
            "convolution_sides": [3],
            "network": "cnn",
        },
    ]
    for number, way in enumerate(ways):
        write_run(tmp_path / f"runs/{number}", "coins", (3.0, 5.0), **way)
    write_cross_play(tmp_path / "runs/met", "coins", {"stay": (0.0, None, None)})
    frame = load(tmp_path / "runs")
    names = ["anneal_learning_rate", "convolution_sides", "learning_rate", "memory", "num_envs"]
    assert columns_of(frame) == names
    assert [str(frame[name].dtype) for name in names] == [
        "boolean",
        "object",
        "float64",
        "object",
        "Int64",
    ]
    seeds = frame[frame.record == "seed"]
    for way in ways:
        found = seeds[seeds.learning_rate == way["learning_rate"]]
        sides = ",".join(map(str, way["convolution_sides"]))
        assert (
            found[names].to_numpy().tolist()
            == [
                [
                    way["anneal_learning_rate"],
                    sides,
                    way["learning_rate"],
                    way["memory"],
                    way["num_envs"],
                ]
            ]
            * 2
        )
    assert seeds.groupby(["learning_rate", "memory"]).seed.count().to_dict() == {
        (1e-3, "none"): 2,
        (5e-4, "gru"): 2,
    }
    assert frame[frame.record == "mixture"][names].isna().to_numpy().tolist() == [
        [True, False, True, False, True]
    ]
    assert columns_of(load(tmp_path / "runs/0")) == []


def test_a_swept_number_of_a_game_is_a_column(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    harms = (-2.0, -3.0, -0.0005000000237487257)  # as float32 has it
    for number, harm in enumerate(harms):
        monkeypatch.setattr(
            "report_folders.described",
            lambda *game, harm=harm: describe(*game) | {"params": {"harm": harm, "length": 9}},
        )
        asked = {} if harm == -2.0 else {"harm": f"{harm:.1g}"}  # the first has that of its game
        write_run(
            tmp_path / f"coins{number}", "coins", (1.0,), rules="own", provenance={"params": asked}
        )
    for value in (4, 5):
        table = {"payoff": {"defect": {"coop": value}}}
        write_run(
            tmp_path / f"pd{value}", "pd_arena", (1.0,), rules="own", provenance={"params": table}
        )
    frame = load(tmp_path)
    assert columns_of(frame) == ["param.harm", "param.payoff[defect][coop]"]
    assert sorted(frame[frame.game == "coins"]["param.harm"]) == [-3.0, -2.0, -0.0005]
    assert frame[frame.game == "pd_arena"].set_index("params")[
        "param.payoff[defect][coop]"
    ].to_dict() == {
        "payoff[defect][coop]=4": 4,
        "payoff[defect][coop]=5": 5,
    }
    (tmp_path / "data").mkdir()
    (tmp_path / "data/results.csv").write_text(
        write_frame(load_both([tmp_path / "pd4", tmp_path / "pd5"])[0])
    )
    assert load(tmp_path / "data")["param.payoff[defect][coop]"].to_list() == [4, 5]


def test_seeds_that_started_from_different_policies_are_told_apart_where_they_have_one_number(
    tmp_path: Path,
) -> None:
    for name, earned in (("calm", 3.0), ("envious", 5.0)):
        (tmp_path / name).mkdir()
        write_run(tmp_path / f"from_{name}", "coins", (earned,), init_from=str(tmp_path / name))
    frame = load(tmp_path / "from_calm", tmp_path / "from_envious")
    assert sorted(zip(frame.init_from, frame.collective_return, strict=True)) == [
        ("calm", 3.0),
        ("envious", 5.0),
    ]
    curves = load_curves(tmp_path / "from_calm", tmp_path / "from_envious")
    assert curves.groupby("run").collective_return.max().to_dict() == dict(
        zip(frame.run, frame.collective_return, strict=True)
    )
    write_run(
        tmp_path / "from_envious", "coins", (5.0,), first=1, init_from=str(tmp_path / "envious")
    )
    frame = load(tmp_path / "from_calm", tmp_path / "from_envious")
    assert (frame.run.nunique(), "init_from" in frame) == (1, False), "each seed may have its own"


@pytest.mark.parametrize(
    ("values", "sort", "column"),
    [
        ([1, None, 2], "Int64", [1, pd.NA, 2]),
        ([1, 0.5, None], "float64", [1.0, 0.5, NONE]),
        ([True, None], "boolean", [True, pd.NA]),
        ([[45.0, 90.0], "a", None, True], "object", ["45,90", "a", "", "true"]),
        ([[[1, "random"], [2, "stay"]]], "object", ["1=random,2=stay"]),
        ([10**400, 0.5], "object", [f"1{'0' * 400}", "0.5"]),
    ],
)
def test_the_type_of_a_column(values: list[Any], sort: str, column: list[Any]) -> None:
    made = column_of(values)
    assert (str(made.dtype), made.to_list()) == (sort, column)

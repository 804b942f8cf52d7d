"""The page of results beside the paper: what its cells and findings say."""

import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any
from unittest import mock

import pandas as pd
import pytest
from report_folders import (
    PAPERS,
    read,
    write_cross_play,
    write_diagram,
    write_everything,
    write_run,
    write_speeds,
    write_training,
)

from bench.paper import __main__ as paper
from bench.paper.contents import INDIVIDUAL, games_of, under_the_papers_rules
from bench.paper.speeds import FILES, read_speeds
from sjdsl.results.selecting import cell_of

ROOT = Path(__file__).parents[2]
NOW: Mapping[tuple[str, str], Any] = {
    ("coins", "socialjax"): ("c02", 2),
    ("gift_refinement", "socialjax+automatic"): ("a17", 5),
}


def page_of(*folders: Path) -> str:
    found = read(*folders)
    speeds = {FILES[name]: frame for name, frame in read_speeds(ROOT / paper.DATA, []).items()}
    data = {paper.RESULTS: found.frame, paper.CURVES: found.curves, **speeds}
    with mock.patch("bench.paper.contents.rules_now", lambda *game: NOW.get(game)):
        sections = paper.sections_of(data)
    marks = "\n\n".join(f"<!-- {name} -->\n<!-- end {name} -->" for name in sections)
    return paper.made_page(marks + "\n", sections)


def test_everything(tmp_path: Path, golden: Callable[[Path, str], None]) -> None:
    """What cells and findings say of runs, diagrams and sweeps under the paper's rules and under others; not what was measured."""
    write_everything(tmp_path)
    text = page_of(tmp_path).replace(str(tmp_path), "runs")
    golden(Path(__file__).with_name("paper_page.txt"), text[: text.index("<!-- speed -->")])


def test_ore_in_coop_mining_is_that_of_each_released_configuration() -> None:
    """SVO was released with twice the ore of IPPO: a run of SVO without it is not one under the paper's rules."""
    twice = "spawn_gold=0.00016 spawn_iron=0.0004"
    runs = [("common", ""), ("common", twice), ("svo", twice), ("svo", "")]
    row = {"record": "seed", "game": "coop_mining", "variant": "socialjax", "algorithm": "ippo"}
    frame = pd.DataFrame([{**row, "reward": reward, "params": params} for reward, params in runs])
    assert under_the_papers_rules(frame).params.to_list() == [
        "",
        twice,
        "",
        "spawn_gold=8e-05 spawn_iron=0.0002",
    ]


def test_claims_compare_seeds_with_the_same_ore() -> None:
    """Exchange was released with twice the ore, so its ratios 0 and 1 are the runs of individual and common reward with twice the ore."""
    twice = "spawn_gold=0.00016 spawn_iron=0.0004"
    runs = [
        ("individual", "", 1.0),
        ("common", "", 2.0),
        ("exchange", twice, 3.0),
        ("individual", twice, 4.0),
    ]
    columns = {
        "record": "seed",
        "game": "coop_mining",
        "hash": "c0",
        "variant": "socialjax",
        "map": "",
        "num_agents": 6,
        "status": "done",
    }
    columns |= {
        "algorithm": "ippo",
        "sharing": "shared",
        "steps": 10,
        "preset": "",
        "hardware": "",
        "settings": "{}",
    }
    rows = [
        {
            **columns,
            "reward": reward,
            "params": params,
            "run": f"{reward} {params}",
            "exchange_ratio": 0.5,
            "collective_return": earned,
        }
        for reward, params, earned in runs
    ]
    game = next(
        game
        for game in games_of(under_the_papers_rules(pd.DataFrame(rows)))
        if game.published == "coop_mining"
    )
    assert {ratio: cell.values for ratio, cell in game.by_ratio.items()} == {
        0.0: (4.0,),
        0.5: (3.0,),
    }
    cell = game.cell(INDIVIDUAL)
    assert cell is not None
    assert cell.values == (1.0,)


def test_of_two_runs_of_one_length_the_one_with_a_presets_settings_is_shown() -> None:
    columns = {"status": "done", "steps": 10, "hardware": "", "settings": "{}"}
    frame = pd.DataFrame(
        [
            {**columns, "run": run, "preset": preset, "collective_return": earned}
            for run, preset, earned in (("a", "", 1.0), ("b", "two_cores", 2.0))
        ]
    )
    cell = cell_of(frame)
    assert cell is not None
    assert cell.values == (2.0,)


def test_the_chosen_weight_of_svo_is_the_one_that_earns_most(tmp_path: Path) -> None:
    for game, weights in (("coins", {0.4: 20.0, 1.0: 10.0}), ("harvest_open", {1.0: 30.0})):
        write_cross_play(tmp_path / game, game, {"random": (0.0, None, None)}, PAPERS["rules"])
        for weight, earned in weights.items():
            write_run(
                tmp_path / f"{game}_{weight}",
                game,
                (earned, earned),
                reward="svo",
                svo_weight=weight,
                svo_angle=90.0,
                **PAPERS,
            )
    with mock.patch("sjdsl.results.sections.interquartile_means", return_value={}) as means:
        text = page_of(tmp_path)
    (scores,) = means.call_args.args
    assert "the chosen weight of SVO is the one of those tried that earns most" in text
    assert {way: own[0].tolist() for way, own in scores.items()} == {
        "IPPO, SVO 90°, chosen weight": pytest.approx([20 / 164, 30 / 420]),
        "IPPO, SVO 90°, weight 1": pytest.approx([10 / 164, 30 / 420]),
    }


def test_scores_are_over_all_games_even_if_more_could_be_compared_in_some(tmp_path: Path) -> None:
    """Otherwise, running a further way of training in the easy games alone would take the hard ones out, and raise all scores."""
    for game in ("coins", "harvest_open", "clean_up"):
        write_run(tmp_path / f"{game}_common", game, (30.0, 50.0), reward="common", **PAPERS)
        write_cross_play(
            tmp_path / f"{game}_random", game, {"random": (0.0, None, None)}, PAPERS["rules"]
        )
        if game != "clean_up":
            for ratio in (0.25, 0.5, 0.75):
                write_run(
                    tmp_path / f"{game}_{ratio}",
                    game,
                    (10.0, 20.0),
                    reward="exchange",
                    exchange_ratio=ratio,
                    **PAPERS,
                )
    with mock.patch("sjdsl.results.sections.interquartile_means", return_value={}) as means:
        text = page_of(tmp_path)
    (scores,) = means.call_args.args
    assert {way: own.shape for way, own in scores.items()} == {"IPPO, common": (2, 3)}
    assert (
        "not run in all of these games: IPPO, exchange 0.25 (2 of 3); IPPO, exchange 0.5 (2 of 3)"
        in text
    )


def test_of_several_diagrams_the_one_over_the_most_seeds_counts(tmp_path: Path) -> None:
    write_run(
        tmp_path / "run", "coins", (1.0, 2.0), **PAPERS
    )  # so that the rules have the name of the variant
    contrasts = dict.fromkeys(("A", "B", "fear"), (3.0, 2.0, 4.0)) | {"greed": (0.0, -1.0, 1.0)}
    for pools, seeds, outcome in (("a", 12, "dilemma"), ("b", 6, "undecided")):
        write_diagram(
            tmp_path / pools,
            "coins",
            contrasts,
            outcome,
            rules=PAPERS["rules"],
            agents=2,
            pools=pools,
            seeds=seeds,
        )
    line = next(
        line
        for line in page_of(tmp_path).splitlines()
        if line.startswith("| The diagram of trained agents")
    )
    assert "holds: coins" in line


@pytest.mark.parametrize(
    ("fear", "verdict"), [((0.0, -1.0, 1.0), "undecided"), ((-2.0, -3.0, -1.0), "does not hold")]
)
def test_a_dilemma_by_greed_alone_is_a_dilemma_but_may_not_be_the_papers(
    tmp_path: Path, fear: tuple[float, float, float], verdict: str
) -> None:
    write_run(tmp_path / "run", "coins", (1.0, 2.0), **PAPERS)
    contrasts = dict.fromkeys(("A", "B", "greed"), (3.0, 2.0, 4.0)) | {"fear": fear}
    write_diagram(
        tmp_path / "diagram", "coins", contrasts, "dilemma", rules=PAPERS["rules"], agents=2
    )
    assert verdict_on(page_of(tmp_path), "The diagram of trained agents is a dilemma") == "holds"
    assert (
        verdict_on(
            page_of(tmp_path),
            "The diagram of trained agents is a dilemma with the paper's fear or greed",
        )
        == verdict
    )


@pytest.mark.parametrize(
    ("last", "verdict"),
    [
        ((150.0, 150.0), "holds"),
        ((190.0, 190.0), "does not hold"),
        ((150.0, 190.0), "undecided"),
        (None, "not run"),
    ],
)
def test_the_ratio_that_is_chosen_is_compared_with_the_papers(
    tmp_path: Path, last: tuple[float, ...] | None, verdict: str
) -> None:
    """The paper's is 1/2; if only common reward earns nearly the most, it is 1."""
    earned = {
        0.0: (10.0, 10.0),
        0.25: (50.0, 50.0),
        0.5: (150.0, 150.0),
        0.75: (150.0, 150.0),
        1.0: last,
    }
    for ratio, returns in earned.items():
        way: dict[str, Any] = {0.0: {"reward": "individual"}, 1.0: {"reward": "common"}}.get(
            ratio, {"reward": "exchange", "exchange_ratio": ratio}
        )
        if returns is not None:
            write_run(tmp_path / f"{ratio}", "coins", returns, **way, **PAPERS)
    assert verdict_on(page_of(tmp_path), "The 95 % rule chooses the paper's ratio") == verdict


def verdict_on(page: str, claim: str) -> str:
    """Returns the verdict on a claim in Coins."""
    line = next(line for line in page.splitlines() if line.startswith(f"| {claim} |"))
    return next(
        one
        for one in ("holds", "does not hold", "undecided", "not run")
        if re.search(rf"[|;] {one}: (all|[^;|]*coins)", line)
    )


def test_speeds_are_taken_in_and_stand_beside_the_published_ones(tmp_path: Path) -> None:
    write_speeds(
        tmp_path / "speed.json", {("coins", None, 128): 4e5, ("harvest_open", 20, 1): 900.0}
    )
    write_training(tmp_path / "training.json", {"coins": (0.2, 0.4, 0.25)})
    found = read_speeds(ROOT / paper.DATA, [tmp_path / "speed.json", tmp_path / "training.json"])
    ours = found["speeds"][found["speeds"].hardware == "Some CPU, 2 cores"]
    assert ours[["game", "crowd", "num_envs", "rate"]].to_numpy().tolist() == [
        ["coins", False, 128, 4e5],
        ["harvest_open", True, 1, 900.0],
    ]
    (update,) = found["updates"][found["updates"].hardware == "Some CPU, 2 cores"].itertuples()
    assert (update.rate, update.slowest, update.fastest, update.rounds) == (
        32_000.0,
        20_000.0,
        40_000.0,
        3,
    )
    speed = paper.speed(ours).tables[0]
    row, theirs = (dict(zip(speed.headings, line, strict=True)) for line in speed.rows[:2])
    assert (row["128"].text, theirs["128"].text) == ("400k [360k, 440k]", "260k")
    hours = paper.hours(found["updates"].loc[[update.Index]]).tables[0].rows[0]
    assert (
        hours[5].text == "8.681 [6.944, 13.89]"
    )  # 1e9 steps at 32,000, 40,000 and 20,000 a second


def test_a_catalogue_of_random_policies_is_taken_in(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    before = paper.read_data([])[paper.RESULTS]
    after = paper.read_data([Path("docs/games.json")])[paper.RESULTS]
    assert (after.record == "random").sum() >= (before.record == "random").sum() > 10
    assert not after[after.record == "random"].duplicated(["game", "hash"]).any()

"""The page of results beside the paper: what its cells and findings say."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any
from unittest import mock

import pandas as pd
import pytest
from report_folders import (
    read,
    write_everything,
    write_speeds,
    write_training,
)

from bench.paper import __main__ as paper
from bench.paper.contents import under_the_papers_rules
from bench.paper.speeds import FILES, read_speeds

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
    return paper.fill_page(marks + "\n", sections)


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
    assert hours[5].text == "8.7 [6.9, 13.9]"  # 1e9 steps at 32,000, 40,000 and 20,000 a second


def test_a_catalogue_of_random_policies_is_taken_in(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    before = paper.read_data([])[paper.RESULTS]
    after = paper.read_data([Path("docs/games.json")])[paper.RESULTS]
    assert (after.record == "random").sum() >= (before.record == "random").sum() > 10
    assert not after[after.record == "random"].duplicated(["game", "hash"]).any()

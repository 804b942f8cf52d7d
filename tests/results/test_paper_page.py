"""The page of results beside the paper: what its cells and findings say, and which commands find what is empty."""

import shlex
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple
from unittest import mock

import click
import pytest
from report_folders import (
    AGENTS,
    PAPERS,
    Found,
    read,
    write_cross_play,
    write_diagram,
    write_run,
    write_speeds,
    write_sweep,
    write_training,
)

from bench.paper import __main__ as paper
from bench.paper.speeds import FILES, read_speeds
from bench.speed.__main__ import main as measures
from sjdsl.cli import commands

ROOT = Path(__file__).parents[2]
CONTRASTS = dict.fromkeys(("A", "B", "fear", "greed"), (1.0, 0.5, 1.5))
NOW: Mapping[tuple[str, str], Any] = {
    ("coins", "socialjax"): ("c02", 2),
    ("gift_refinement", "socialjax+automatic"): ("a17", 5),
}


class Page(NamedTuple):
    """The page, and the numbers of its tables."""

    text: str
    tables: dict[str, list[dict[str, Any]]]
    notes: list[str]

    def line(self, start: str, which: int = 0) -> list[str]:
        """Returns the cells of a row of a table that begins so."""
        rows = [row for row in self.text.splitlines() if row.startswith(f"| {start}")]
        return [cell.strip() for cell in rows[which].strip("|").split(" | ")]

    def section(self, title: str) -> str:
        return self.text.split(f"\n## {title}")[1].split("\n## ")[0]


def page_of(*folders: Path) -> Page:
    found: Found = read(*folders)
    speeds = {FILES[name]: frame for name, frame in read_speeds(ROOT / paper.DATA, []).items()}
    data = {paper.RESULTS: found.frame, paper.CURVES: found.curves, **speeds}
    notes = [*found.notes]
    with mock.patch("bench.paper.contents.rules_now", lambda *game: NOW.get(game)):
        made = paper.sections_of(data, notes)
        text = paper.made_page(data, made, notes)
    return Page(text, {table.name: table.records for section in made for table in section.tables}, notes)


@pytest.fixture(scope="module")
def empty() -> Page:
    """The page where nothing was trained."""
    return page_of()


def test_a_cell_beside_the_published_one(tmp_path: Path) -> None:
    write_run(tmp_path / "all", "coins", (150.0, 160.0, 155.0), reward="common", **PAPERS)
    write_run(tmp_path / "own", "coins", (100.0,), reward="individual", **PAPERS)
    page = page_of(tmp_path)
    assert page.line("coins, variant socialjax | ours")[2:7:4] == ["100 (1 seed)", "155 [142.6, 167.4] (3 seeds)"]
    assert page.line(" | ours - published")[2:7:4] == ["+61", "-9, inside"]  # one seed: neither inside nor outside of an interval
    ours, theirs, difference = [row for row in page.tables["exchange"] if row["game"] in ("coins, variant socialjax", "")][:3]
    assert (ours["1: common mean"], ours["1: common seeds"], ours["1: common hardware"]) == (155, 3, "cpu")
    assert (theirs["1: common published"], difference["1: common difference"]) == (164, -9)


def test_a_cell_with_a_seed_that_has_failed_has_no_difference(tmp_path: Path) -> None:
    write_run(tmp_path, "coins", (150.0, 160.0, 170.0), diverged=(1,), reward="common", **PAPERS)
    page = page_of(tmp_path)
    assert page.line("coins, variant socialjax | ours")[6] == "failed: 1 of 3 seeds"
    assert "ours - published" not in page.section("Returns by exchange ratio")


def test_the_rule_and_how_sure_its_choice_is(tmp_path: Path) -> None:
    for number, (reward, returns) in enumerate({"individual": (10.0, 12.0), "exchange": (96.0, 98.0), "common": (99.0, 101.0)}.items()):
        write_run(tmp_path / str(number), "orchard", returns, reward=reward, **({"exchange_ratio": 0.5} if reward == "exchange" else {}))
    page = page_of(tmp_path)
    assert page.line("orchard | ours")[7] == "0.5 of 3 ratios"
    (row,) = page.tables["exchange_choices"]
    assert {name: share for name, share in row.items() if name != "game"} == {"0: individual": 0, "0.5": 1, "1: common": 0, "none": 0}


def test_of_several_ways_of_training_the_longer_is_shown_and_the_other_named(tmp_path: Path) -> None:
    write_run(tmp_path / "short", "coins", (10.0, 12.0, 14.0), reward="common", **PAPERS)
    write_run(tmp_path / "long", "coins", (50.0, 52.0), first=100, reward="common", total_timesteps=800, num_envs=20, **PAPERS)
    page = page_of(tmp_path)
    assert page.line("coins, variant socialjax | ours")[6] == "51 [38.29, 63.71]"
    (note,) = page.notes
    assert note.startswith("for coins, variant socialjax, IPPO, common, tables show 2 seeds, 800 steps, unnamed CPU")
    assert "not 3 seeds, 400 steps, unnamed CPU" in note


def test_the_method_says_how_long_was_trained_and_what_common_reward_is(tmp_path: Path) -> None:
    write_run(tmp_path / "short", "coins", (10.0, 12.0), reward="common", common_reward="mean")
    write_run(tmp_path / "long", "harvest_open", (10.0, 12.0), reward="common", algorithm="mappo", total_timesteps=800, num_envs=20)
    method = page_of(tmp_path).section("Method")
    assert "trained for 400 to 800 environment steps, one of the paper for 300M" in method
    assert "rewards: their mean in IPPO; their sum in MAPPO; in the paper, their sum." in method
    write_run(tmp_path / "both", "pd_arena", (10.0, 12.0), reward="common")
    assert "their mean in some runs of IPPO; their sum in some runs of IPPO, MAPPO;" in page_of(tmp_path).section("Method")


def test_the_page_begins_with_which_claims_hold(tmp_path: Path) -> None:
    returns = {
        ("coins", "individual"): (10.0, 12.0, 11.0),
        ("coins", "common"): (150.0, 160.0, 155.0),  # as published: more
        ("mushrooms", "individual"): (300.0, 301.0, 302.0),
        ("mushrooms", "common"): (100.0, 101.0, 102.0),  # the other way round
        ("pd_arena", "individual"): (100.0, 300.0),
        ("pd_arena", "common"): (110.0, 310.0),  # too near to each other
        ("clean_up", "common"): (900.0, 901.0),  # with nothing to compare it with
    }
    for (game, reward), found in returns.items():
        write_run(tmp_path / f"{game}_{reward}", game, found, reward=reward, **PAPERS)
    contrasts = {"A": (60.0, 50.0, 70.0), "B": (5.0, 1.0, 11.0), "fear": (40.0, 30.0, 50.0), "greed": (2.0, -3.0, 7.0)}
    write_diagram(tmp_path / "d", "coins", contrasts, "dilemma", rules="c02")
    page = page_of(tmp_path)
    first = "* **Common reward earns more than individual reward in 1 of 3 games it was run in** (coins); not in mushrooms; undecided in pd_arena.\n"
    assert page.text.startswith(f"# Results\n\n## Findings\n\n{first}")
    found = {row["claim"]: row for row in page.tables["findings"]}
    claim = "common reward earns more than individual reward"
    verdicts = [found[claim][f"ours {game}"] for game in ("coins", "mushrooms", "pd_arena", "clean_up", "harvest_open")]
    assert verdicts == ["holds", "does not hold", "undecided", "not run", "not run"]
    assert page.line(claim)[1:] == [
        "in 9 games",
        "holds: coins; does not hold: mushrooms; undecided: pd_arena; "
        "not run: harvest_open, harvest_closed, harvest_partnership, clean_up, coop_mining, gift_refinement",
        "1 of 9",
    ]
    assert found["exchange 0.5 earns more than common reward"]["ours clean_up"] == "not run"  # and more in the paper
    (diagram,) = (row for claim, row in found.items() if "diagram" in claim)
    assert [diagram[f"ours {game}"] for game in ("coins", "clean_up")] == ["holds", "not run"]


def test_ways_are_alike_where_their_difference_is_small(tmp_path: Path) -> None:
    shared = {"coins": (100.0, 101.0, 102.0), "pd_arena": (100.0, 101.0, 102.0), "mushrooms": (100.0, 150.0)}
    apart = {"coins": (101.0, 102.0, 103.0), "pd_arena": (150.0, 151.0, 152.0), "mushrooms": (120.0, 180.0)}
    for sharing, returns in (("shared", shared), ("per_agent", apart)):
        for game, found in returns.items():
            write_run(tmp_path / f"{game}_{sharing}", game, found, sharing=sharing, reward="individual", **PAPERS)
    page = page_of(tmp_path)
    (row,) = (row for row in page.tables["findings"] if "alike" in row["claim"])
    verdicts = [row[f"ours {game}"] for game in ("coins", "pd_arena", "mushrooms", "clean_up")]
    assert verdicts == ["holds", "does not hold", "undecided", "not run"]
    assert page.line("coins, variant socialjax | IPPO, individual")[2:5] == [
        "101 [98.52, 103.5]",
        "102 [99.52, 104.5]",
        "1 [-1.267, 3.267]",
    ]


def test_cells_below_a_random_policy_are_named(tmp_path: Path) -> None:
    for game, random in (("coins", 0.0), ("harvest_open", 60.0)):
        write_cross_play(tmp_path / f"{game}_random", game, {"random": (random / AGENTS[game], None, None)})
    write_run(tmp_path / "coins", "coins", (17.0, 14.0))
    write_run(tmp_path / "own", "harvest_open", (30.0, 40.0))
    write_run(tmp_path / "all", "harvest_open", (59.0, 62.0), reward="common")
    assert "Returns below those of a random policy: harvest_open, rules 4a7 (individual). " in page_of(tmp_path).text


def test_a_game_that_the_paper_did_not_play_so_has_nothing_published_beside_it(tmp_path: Path) -> None:
    write_run(tmp_path / "run", "coins", (1.0, 2.0), reward="common", provenance={"params": {"length": 20}})
    page = page_of(tmp_path)
    rows = page.section("Returns by exchange ratio").splitlines()
    place = next(number for number, row in enumerate(rows) if row.startswith("| coins, length=20 | ours"))
    assert rows[place + 1].startswith("| coins, variant socialjax | ours |")
    assert not [row for row in page.tables["metrics"] if "length=20" in row["game"]]


def test_settings_of_a_column_or_a_row_that_differ_are_said(tmp_path: Path) -> None:
    """Cells of one game are compared; what is alike in all is not said, nor what common reward alone has."""
    for game, kind in {"coins": {}, "harvest_open": {"common_reward": "mean"}, "pd_arena": {"gamma": 0.5}}.items():
        for reward in ("individual", "common"):
            write_run(
                tmp_path / f"{game}_{reward}", game, (1.0, 2.0), reward=reward, learning_rate=0.25, **(kind if reward == "common" else {})
            )
    write_run(tmp_path / "apart", "coins", (1.0, 2.0), reward="common", sharing="per_agent", learning_rate=0.25, common_reward="mean")
    said = [line for line in page_of(tmp_path).text.splitlines() if line.startswith("* ") and "` is " in line]
    line = "`gamma` is the default in {}; 0.5 in {}."
    row = '* coins, IPPO, common: `common_reward` is the default in shared; "mean" in separate.'
    assert said == [f"* pd_arena: {line.format('individual', 'common')}", row, f"* pd_arena: {line.format('0: individual', '1: common')}"]


def test_the_angles_have_the_fresh_seeds_and_not_those_that_chose_the_weight(tmp_path: Path) -> None:
    cells = tmp_path / "svo/cells"
    write_run(cells / "weight-0.4", "coins", (100.0, 120.0), reward="svo", svo_weight=0.4)
    write_run(cells / "weight-0.6", "coins", (140.0, 150.0), reward="svo", svo_weight=0.6)
    write_run(cells / "angle-45", "coins", (60.0, 80.0), first=2, reward="svo", svo_weight=0.6, svo_angle=45)
    write_run(cells / "angle-90", "coins", (130.0, 144.0), first=2, reward="svo", svo_weight=0.6)
    write_run(tmp_path / "arena", "pd_arena", (30.0, 50.0), reward="svo", svo_weight=0.0)
    write_sweep(tmp_path / "svo", "svo", {path.name: 1 + path.name.startswith("angle") for path in cells.iterdir()})
    page = page_of(tmp_path)
    weights, angles = ({k: v for k, v in page.tables[name][0].items() if k.endswith("mean")} for name in ("svo_weights", "svo_angles"))
    assert weights == {"0.4 mean": 110, "0.6 mean": 145}
    assert angles == {"45° mean": 70, "90° mean": 137}
    assert "In pd_arena, the chosen weight is 0, which is individual reward." in page.text
    (command,) = (row for row in page.text.splitlines() if "--protocol svo" in row and "--variant" not in row)
    assert command.startswith("sjdsl sweep coins --protocol svo")  # of pd_arena, where the weight is 0, one angle is enough


def test_metrics_are_on_the_scale_of_the_paper(tmp_path: Path) -> None:
    games = {"coop_mining": ("event ores_shared", 480), "mushrooms": ("event eaten[blue]", 20), "coins": ("event own_coins", 60)}
    for game, (name, _) in games.items():
        write_run(tmp_path / game, game, (1.0, 1.0), measures={name: (60.0, 60.0)}, reward="individual", **PAPERS)
    found = {row["game"]: row["IPPO individual mean"] for row in page_of(tmp_path).tables["metrics"] if "IPPO individual mean" in row}
    # 8 a gold ore; mushrooms of one agent of three
    assert found == {f"{game}, variant socialjax": wanted for game, (_, wanted) in games.items()}


def test_numbers_that_the_released_code_sets_for_one_way_of_training_are_part_of_the_papers_rules(tmp_path: Path) -> None:
    more = {"params": {"spawn_iron": 0.0004, "spawn_gold": "1.6e-4"}}
    for way, asked in {"exchange": more, "individual": {}}.items():
        write_run(tmp_path / way, "coop_mining", (10.0, 12.0), reward=way, provenance={"variant": "socialjax", **asked})
    rows = [row["game"] for row in page_of(tmp_path).tables["exchange"] if row["game"].startswith("coop_mining")]
    assert rows == ["coop_mining, variant socialjax"]
    write_run(tmp_path / "other", "coop_mining", (1.0, 2.0), reward="individual", provenance={"variant": "socialjax", **more}, first=5)
    rows = [row["game"] for row in page_of(tmp_path).tables["exchange"] if row["game"].startswith("coop_mining")]
    assert len(rows) == 2


def test_scores_of_svo_are_at_each_games_chosen_weight(tmp_path: Path) -> None:
    """The seeds that chose the weight are not among its scores."""
    for game, weight, random in (("coins", 0.4, 0.0), ("harvest_open", 0.8, 10.0)):
        cells = tmp_path / "svo/cells"
        write_run(cells / f"{game}_chose", game, (1000.0, 1010.0), reward="svo", svo_weight=weight, **PAPERS)
        write_run(cells / f"{game}_is", game, (30.0, 50.0), first=2, reward="svo", svo_weight=weight, **PAPERS)
        write_cross_play(tmp_path / game, game, {"random": (random / AGENTS[game], None, None)}, PAPERS["rules"])
    write_sweep(tmp_path / "svo", "svo", {path.name: 1 + path.name.endswith("is") for path in cells.iterdir()})
    with mock.patch("sjdsl.results.sections.interquartile_means", return_value={}) as means:
        text = page_of(tmp_path).text
    (scores,) = means.call_args.args
    assert list(scores) == ["IPPO, SVO 90°, chosen weight"]
    coins, harvest = scores["IPPO, SVO 90°, chosen weight"].T
    assert coins.tolist() == pytest.approx([30 / 164, 50 / 164])
    assert harvest.tolist() == pytest.approx([20 / 410, 40 / 410])
    assert "The chosen weight of SVO is the one chosen in each game's own sweep." in text


def test_diagrams_of_the_papers_rules_alone_have_what_it_found_beside_them(tmp_path: Path, empty: Page) -> None:
    for rules, scripted in (("c02", False), ("c01", False), ("c01", True)):
        write_diagram(tmp_path / f"{rules}{scripted}", "coins", CONTRASTS, "dilemma", rules=rules, scripted=scripted)
    section = page_of(tmp_path).section("Schelling diagrams")
    rows = [[cell.strip() for cell in row.strip("|").split(" | ")] for row in section.splitlines() if row.startswith("| coins")]
    said = "fear, called a prisoner's dilemma (a prisoner's dilemma has greed as well)"
    assert [(row[0], row[1], row[8]) for row in rows] == [
        ("coins, variant socialjax", "`runs/coins_common`", said),
        ("coins", "`runs/coins_common`", ""),
        ("coins", "`cooperator`", ""),
    ]
    assert "sjdsl schelling coins " not in section
    assert f"| coins, variant socialjax |  |  |  |  |  |  |  | {said} |" in empty.text


def test_commands_are_there_and_carry_the_variant_that_the_paper_played(empty: Page) -> None:
    assert empty.line(" | published", which=8)[2] == "144 ± 40"
    called = [shlex.split(row) for row in empty.text.splitlines() if row.startswith("sjdsl ")]
    assert {call[1] for call in called} == {"sweep", "schelling"}
    above = click.Context(commands, info_name="sjdsl")
    for _, name, *arguments in called:
        command = commands.get_command(above, name)
        assert command is not None, name
        command.make_context(name, [*arguments], parent=above)
        variant = "socialjax+automatic" if "gift_refinement" in arguments else "socialjax"
        assert arguments[arguments.index("--variant") + 1] == variant
        assert arguments[-1].endswith(f"_{variant}")
    (measuring,) = [shlex.split(row)[3:] for row in empty.text.splitlines() if row.startswith("python -m bench.speed ")]
    measures.commands[measuring[0]].make_context(measuring[0], measuring[1:])


def test_the_variant_that_the_paper_played_is_another_in_one_game(tmp_path: Path) -> None:
    """Its findings and tables are of that variant; runs under the rules of the other games have nothing published beside them."""
    rewards = {"individual": (100.0, 101.0, 102.0), "common": (500.0, 510.0, 505.0)}
    for variant, rules in (("socialjax", "b52"), ("socialjax+automatic", "a17")):
        for reward, returns in rewards.items():
            asked = {"provenance": {"variant": variant}, "reward": reward}
            write_run(tmp_path / f"{variant}_{reward}", "gift_refinement", returns, rules=rules, **asked)
    write_diagram(tmp_path / "diagram", "gift_refinement", CONTRASTS, "dilemma", rules="a17", agents=5)
    page = page_of(tmp_path)
    found = {row["claim"]: row.get("ours gift_refinement") for row in page.tables["findings"]}
    assert found["common reward earns more than individual reward"] == "holds"
    assert [verdict for claim, verdict in found.items() if "diagram" in claim] == ["holds"]
    rows = [row["game"] for row in page.tables["exchange"]]
    places = [number for number, row in enumerate(page.tables["exchange"]) if row.get("1: common published") == 505]
    assert [rows[place - 1] for place in places] == ["gift_refinement, variant socialjax+automatic"]
    assert "| dilemma, fear and greed | fear, called a stag hunt | 5 training seeds |" in page.text
    scores = page.section("Over games").splitlines()
    assert [row for row in scores if row.startswith("sjdsl crossplay")] == [
        "sjdsl crossplay gift_refinement --variant socialjax+automatic --policies random --episodes 200 -o runs/gift_refinement_random"
    ]


def test_speeds_are_taken_in_and_stand_beside_the_published_ones(tmp_path: Path) -> None:
    write_speeds(tmp_path / "speed.json", {("coins", None, 128): 4e5, ("harvest_open", 20, 1): 900.0})
    write_training(tmp_path / "training.json", {"coins": (0.2, 0.4, 0.25)})
    found = read_speeds(ROOT / paper.DATA, [tmp_path / "speed.json", tmp_path / "training.json"])
    ours = found["speeds"][found["speeds"].hardware == "Some CPU, 2 cores"]
    assert ours[["game", "crowd", "num_envs", "rate"]].to_numpy().tolist() == [["coins", False, 128, 4e5], ["harvest_open", True, 1, 900.0]]
    (update,) = found["updates"][found["updates"].hardware == "Some CPU, 2 cores"].itertuples()
    assert (update.rate, update.slowest, update.fastest, update.rounds) == (32_000.0, 20_000.0, 40_000.0, 3)
    speed = paper.speed(ours).tables[0]
    row, theirs = (dict(zip(speed.headings, line, strict=True)) for line in speed.rows[:2])
    assert (row["128"].text, theirs["128"].text) == ("400k [360k, 440k]", "260k")
    hours = paper.hours(found["updates"].loc[[update.Index]]).tables[0].rows[0]
    assert hours[5].text == "8.681 [6.944, 13.89]"  # 1e9 steps at 32,000, 40,000 and 20,000 a second


def test_a_catalogue_of_random_policies_is_taken_in(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    before = paper.read_data([])[paper.RESULTS]
    after = paper.read_data([Path("docs/games.json")])[paper.RESULTS]
    assert (after.record == "random").sum() >= (before.record == "random").sum() > 10
    assert not after[after.record == "random"].duplicated(["game", "hash"]).any()

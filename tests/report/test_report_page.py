"""The page and the tables of a report: a golden of one of everything, and what each cell may say."""

import csv
import shlex
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click
import pytest
from report_folders import PAPERS, random_returns, write_cross_play, write_diagram, write_run

from sjdsl.cli import commands
from sjdsl.experiments.bundled_rules import is_usual
from sjdsl.report import Evidence, read_folders
from sjdsl.report.contents import contents_of
from sjdsl.report.evidence import SpeedRow
from sjdsl.report.report import Report, make_report
from sjdsl.report.sections.speed import speed

GOLDEN = Path(__file__).parent / "golden"
Golden = Callable[[Path, str], None]


def report_of(*folders: Path, whole_suite: bool = False) -> Report:
    return make_report(read_folders(folders), "sjdsl report runs", whole_suite=whole_suite)


def records(report: Report, table: str) -> list[dict[str, str]]:
    return list(csv.DictReader(report.files[f"tables/{table}.csv"].splitlines()))


def line(report: Report, start: str, which: int = 0) -> list[str]:
    """Returns the cells of a row of a table on the page that begins so."""
    rows = [row for row in report.page.splitlines() if row.startswith(f"| {start}")]
    return [cell.strip() for cell in rows[which].strip("|").split(" | ")]


def test_golden(written: Path, golden: Golden) -> None:
    golden(GOLDEN / "report.md", (written / "report.md").read_text())
    names = sorted(path.relative_to(written).as_posix() for path in written.rglob("*.csv"))
    golden(
        GOLDEN / "files.txt",
        "\n".join(sorted(path.relative_to(written).as_posix() for path in written.rglob("*") if path.is_file())) + "\n",
    )
    for name in names:
        golden(GOLDEN / name, (written / name).read_text())


def test_pictures(written: Path) -> None:
    pictures = sorted((written / "figures").iterdir())
    curves = {f"curves_{game}" for game in ("coins_variant_socialjax", "harvest_open", "pd_arena")}
    assert {path.stem for path in pictures} == {*curves, "exchange", "speed", "svo"}
    assert all(path.read_bytes()[:4] in (b"\x89PNG", b"<?xm") for path in pictures)
    assert len(pictures) == 12


def test_a_cell_is_the_mean_over_seeds_with_its_interval(tmp_path: Path) -> None:
    found = records(report_of(write_run(tmp_path / "run", "coins", (150.0, 160.0, 155.0), reward="common", **PAPERS)), "exchange")
    cell = next(row for row in found if row["column"] == "1: common")
    # Student's t at 97.5 % with two degrees of freedom, from a printed table: 4.303; the standard error of 150, 160, 155 is 5 / sqrt(3).
    margin = 4.303 * 5 / 3**0.5
    assert abs(float(cell["mean"]) - 155) < 1e-9
    assert abs(float(cell["high"]) - (155 + margin)) < 1e-2
    assert (cell["seeds"], cell["failed"], cell["steps"], cell["hardware"]) == ("3", "0", "400", "cpu")
    assert (cell["published"], cell["difference"], cell["published_inside"]) == ("164", "-9", "yes")


def test_one_seed_has_no_interval_and_no_test(tmp_path: Path) -> None:
    runs = [write_run(tmp_path / reward, "coins", (100.0,), reward=reward, **PAPERS) for reward in ("individual", "common")]
    report = report_of(*runs)
    assert line(report, "coins, variant socialjax | ours")[2] == "100"
    assert line(report, " | ours - published")[2] == "+61"  # neither inside nor outside of an interval
    assert line(report, "coins, variant socialjax | easy")[5:7] == ["0", ""]
    assert any("too few seeds for an interval" in note for note in report.notes)


@pytest.mark.parametrize(("diverged", "said"), [((1,), "failed: 1 of 3 seeds"), ((0, 1, 2), "failed: 3 of 3 seeds")])
def test_a_cell_with_a_seed_that_has_failed_is_never_averaged(tmp_path: Path, diverged: tuple[int, ...], said: str) -> None:
    runs = [write_run(tmp_path / "own", "coins", (10.0, 20.0, 30.0), reward="individual", **PAPERS)]
    runs += [write_run(tmp_path / "shared", "coins", (150.0, 160.0, 170.0), diverged=diverged, reward="common", **PAPERS)]
    report = report_of(*runs)
    assert line(report, "coins, variant socialjax | easy")[3:7] == ["20 [-4.841, 44.84]", said, "", ""]
    row = line(report, "coins, variant socialjax | ours")
    assert row[6] == said
    cell = next(row for row in records(report, "exchange") if row["column"] == "1: common")
    assert {row["way"].split(", ")[1] for row in records(report, "learning_curves")} == {"individual"}
    assert (cell["mean"], cell["low"], cell["failed"], cell["difference"]) == ("", "", str(len(diverged)), "")


def test_the_rule_and_how_sure_its_choice_is(tmp_path: Path) -> None:
    runs = [
        write_run(tmp_path / "0", "orchard", (10.0, 12.0), reward="individual"),
        write_run(tmp_path / "half", "orchard", (96.0, 98.0), reward="exchange", exchange_ratio=0.5),
        write_run(tmp_path / "1", "orchard", (99.0, 101.0), reward="common"),
    ]
    report = report_of(*runs)
    assert line(report, "orchard | ours")[7] == "0.5 of 3 ratios"
    assert {row["ratio"]: row["frequency"] for row in records(report, "exchange_choices")} == {"0": "0", "0.5": "1", "1": "0", "none": "0"}
    assert "published |" not in report.page.split("## Social")[0].split("## Returns")[1]  # nothing is published of this game


def test_of_several_ways_of_training_the_longer_is_shown_and_the_other_named(tmp_path: Path) -> None:
    short = write_run(tmp_path / "short", "coins", (10.0, 12.0), reward="common")
    long = write_run(tmp_path / "long", "coins", (50.0, 52.0), reward="common", total_timesteps=800, num_envs=20)
    report = report_of(short, long)
    assert line(report, "coins | ours")[6].startswith("51 [")
    (note,) = (note for note in report.notes if "is shown in tables, not" in note)
    assert "800 steps" in note.split("not")[0]
    assert note.endswith("which differs in settings: num_envs 10, not 20")


def test_the_opening_says_how_long_was_trained_and_what_common_reward_is(tmp_path: Path) -> None:
    short = write_run(tmp_path / "short", "coins", (10.0, 12.0), reward="common", common_reward="mean")
    long = write_run(tmp_path / "long", "harvest_open", (10.0, 12.0), reward="common", algorithm="mappo", total_timesteps=800, num_envs=20)
    opening = report_of(short, long).page.split("## Method")[1]
    assert "learnt from 400 to 800 environment steps, one of the paper from 300M" in opening
    assert "rewards: their mean in IPPO; their sum in MAPPO; in the paper their sum." in opening
    both = write_run(tmp_path / "both", "pd_arena", (10.0, 12.0), reward="common")
    assert "their mean in some runs of IPPO; their sum in some runs of IPPO, MAPPO;" in report_of(short, long, both).page
    nothing = report_of(write_run(tmp_path / "other", "orchard", (10.0, 12.0), reward="individual")).page
    assert "learnt from" not in nothing.split("## Method")[1] and "Common reward is" not in nothing


def test_the_suite_begins_with_which_claims_hold(tmp_path: Path) -> None:
    returns = {
        ("coins", "individual"): (10.0, 12.0, 11.0),
        ("coins", "common"): (150.0, 160.0, 155.0),  # as published: more
        ("mushrooms", "individual"): (300.0, 301.0, 302.0),
        ("mushrooms", "common"): (100.0, 101.0, 102.0),  # the other way round
        ("pd_arena", "individual"): (100.0, 300.0),
        ("pd_arena", "common"): (110.0, 310.0),  # too near to each other
        ("clean_up", "common"): (900.0, 901.0),  # with nothing to compare it with
    }
    runs = [write_run(tmp_path / f"{game}_{reward}", game, found, reward=reward, **PAPERS) for (game, reward), found in returns.items()]
    contrasts = {"A": (60.0, 50.0, 70.0), "B": (5.0, 1.0, 11.0), "fear": (40.0, 30.0, 50.0), "greed": (2.0, -3.0, 7.0)}
    write_diagram(tmp_path / "d", "coins", contrasts, "dilemma", rules="c02")
    report = report_of(*runs, tmp_path / "d", whole_suite=True)
    assert report.page.split("\n## ")[1].startswith("Findings\n")
    found = {(row["claim"], row["game"]): row["verdict"] for row in records(report, "findings")}
    claim = "common reward earns more than individual reward"
    verdicts = {game: found[claim, game] for game in ("coins", "mushrooms", "pd_arena", "clean_up", "harvest_open")}
    assert verdicts == dict(zip(verdicts, ("holds", "does not hold", "undecided", "not run", "not run"), strict=True))
    assert line(report, claim)[1:] == [
        "in 9 games",
        "holds: coins; does not hold: mushrooms; undecided: pd_arena; "
        "not run: harvest_open, harvest_closed, harvest_partnership, clean_up, coop_mining, gift_refinement",
        "1 of 9",
    ]
    assert found["exchange 0.5 earns more than common reward", "clean_up"] == "not run"  # and more in the paper
    (diagrams,) = {claim for claim, _ in found if "diagram" in claim}
    assert [found[diagrams, game] for game in ("coins", "clean_up")] == ["holds", "not run"]


def test_ways_are_alike_where_their_difference_is_small(tmp_path: Path) -> None:
    shared = {"coins": (100.0, 101.0, 102.0), "pd_arena": (100.0, 101.0, 102.0), "mushrooms": (100.0, 150.0)}
    apart = {"coins": (101.0, 102.0, 103.0), "pd_arena": (150.0, 151.0, 152.0), "mushrooms": (120.0, 180.0)}
    for sharing, returns in (("shared", shared), ("per_agent", apart)):
        for game, found in returns.items():
            write_run(tmp_path / f"{game}_{sharing}", game, found, sharing=sharing, reward="individual", **PAPERS)
    table = {row["game"]: row["verdict"] for row in records(report_of(tmp_path, whole_suite=True), "findings") if "alike" in row["claim"]}
    assert [table[game] for game in ("coins", "pd_arena", "mushrooms", "clean_up")] == ["holds", "does not hold", "undecided", "not run"]


def test_cells_below_a_random_policy_are_named(tmp_path: Path) -> None:
    random = tmp_path / "games.json"
    random_returns(random, {"harvest_open": 60.0, "coins": 0.0})
    runs = [
        write_run(tmp_path / f"{game}_{reward}", game, returns, reward=reward)
        for game, reward, returns in (
            ("coins", "individual", (17.0, 14.0)),
            ("harvest_open", "individual", (30.0, 40.0)),
            ("harvest_open", "common", (59.0, 62.0)),
        )
    ]
    page = report_of(random, *runs).page
    assert "Below the return of a random policy are: harvest_open (individual). " in page
    assert "Below the return of a random policy" not in report_of(*runs).page


def test_a_game_that_the_paper_did_not_play_so_is_in_no_table_of_its(tmp_path: Path) -> None:
    """Neither a metric of it nor a score is to be had, by no command."""
    other = {"provenance": {"params": {"length": 20}}}
    page = report_of(write_run(tmp_path / "run", "coins", (1.0, 2.0), **other)).page
    metric, over = (page.split(f"## {title}")[1].split("\n## ")[0] for title in ("Cooperation metrics", "Over games"))
    assert "None of the games here is one of them." in metric and "```" not in metric
    assert "There are no two games yet" in over and "```" not in over


def test_curves_of_one_name_are_told_apart_by_their_settings(tmp_path: Path) -> None:
    runs = [write_run(tmp_path / str(rate), "coins", (10.0, 12.0), learning_rate=rate) for rate in (0.25, 0.5)]
    ways = {row["way"] for row in records(report_of(*runs), "learning_curves")}
    assert ways == {f"IPPO, individual (learning_rate {rate}), 2 seeds" for rate in (0.25, 0.5)}


def test_settings_that_differ_between_the_games_of_a_column_are_said(tmp_path: Path) -> None:
    """Cells above each other are compared by who reads them; what is alike in all games is not said."""
    kinds = {"coins": {}, "harvest_open": {"common_reward": "mean"}, "pd_arena": {"common_reward": "mean"}}
    runs = [
        write_run(
            tmp_path / game / reward, game, (10.0, 12.0), reward=reward, learning_rate=0.25, **(kinds[game] if reward == "common" else {})
        )
        for game in kinds
        for reward in ("individual", "common")
    ]
    said = [line for line in report_of(*runs).page.splitlines() if line.startswith("* ") and "` is " in line]
    line = '`common_reward` is the default in coins; "mean" in harvest_open, pd_arena.'
    assert said == [f"* common: {line}", f"* 1: common: {line}"]
    assert not [line for line in report_of(*runs[:2]).page.splitlines() if "common_reward` is" in line]


def test_settings_that_shared_and_separate_parameters_do_not_have_alike_are_said(tmp_path: Path) -> None:
    for sharing, kind in (("shared", "mean"), ("per_agent", "sum")):
        write_run(tmp_path / sharing, "coins", (10.0, 12.0), reward="common", sharing=sharing, common_reward=kind)
    lines = report_of(tmp_path).page.splitlines()
    assert '* coins, IPPO, common: `common_reward` is "mean" in shared; the default in separate.' in lines


def test_the_angles_have_the_fresh_seeds_and_not_those_that_chose_the_weight(evidence: Evidence) -> None:
    report = make_report(evidence, "sjdsl report runs")
    weights = {row["column"]: row["mean"] for row in records(report, "svo_weights") if row["mean"]}
    angles = {row["column"]: row["mean"] for row in records(report, "svo_angles") if row["mean"]}
    assert weights == {"0.4": "110", "0.6": "145"}
    assert angles == {"45°": "70", "90°": "137"}
    assert "the chosen weight is 0" not in report.page


def test_where_the_chosen_weight_of_svo_is_0_one_angle_is_enough(tmp_path: Path) -> None:
    runs = [write_run(tmp_path / game, game, (30.0, 50.0), reward="svo", svo_weight=0.0) for game in ("coins", "pd_arena")]
    page = report_of(*runs).page
    said = "In coins, pd_arena the chosen weight is 0, which is individual reward. All angles are alike then, and one is trained."
    assert said in page
    assert "--protocol svo" not in page


def test_metrics_are_on_the_scale_of_the_paper(tmp_path: Path) -> None:
    games = {
        "coop_mining": ("event ores_shared", 60.0, "480"),
        "mushrooms": ("event eaten[blue]", 60.0, "20"),
        "coins": ("event own_coins", 60.0, "60"),
    }
    runs = [
        write_run(tmp_path / game, game, (1.0, 1.0), measures={name: (value, value)}, reward="individual", **PAPERS)
        for game, (name, value, _) in games.items()
    ]
    found = {row["game"]: row["mean"] for row in records(report_of(*runs), "metrics") if row["column"] == "IPPO individual"}
    assert found == {
        f"{game}, variant socialjax": wanted for game, (_, _, wanted) in games.items()
    }  # 8 a gold ore; mushrooms of one agent of three


def test_other_numbers_and_maps_are_other_games_without_published_figures(tmp_path: Path) -> None:
    runs = [
        write_run(tmp_path / "harmless", "coins", (10.0, 12.0), reward="common", rules="c01", provenance={"params": {"harm": 0}}),
        write_run(tmp_path / "socialjax", "coins", (10.0, 12.0), reward="common", rules="c02", provenance={"variant": "socialjax"}),
    ]
    page = report_of(*runs).page
    assert "| coins, harm=0 | ours |" in page
    assert "| coins, variant socialjax | ours |" in page
    assert page.split("## Returns")[1].split("## Social")[0].count("| published |") == 1


def test_numbers_that_the_released_code_sets_for_one_way_of_training_are_part_of_the_papers_rules(tmp_path: Path) -> None:
    more = {"params": {"spawn_iron": 0.0004, "spawn_gold": "1.6e-4"}}
    ways = {"exchange": more, "svo": more, "individual": {}}
    runs = [
        write_run(tmp_path / way, "coop_mining", (10.0, 12.0), reward=way, provenance={"variant": "socialjax", **asked})
        for way, asked in ways.items()
    ]
    assert [game.label for game in contents_of(read_folders(runs), False).games] == ["coop_mining, variant socialjax"]
    other = write_run(tmp_path / "other", "coop_mining", (10.0, 12.0), reward="individual", provenance={"variant": "socialjax", **more})
    assert len(contents_of(read_folders([other]), False).games[0].label.split(", ")) == 3


def test_a_number_that_the_game_has_anyway_makes_no_other_game(tmp_path: Path) -> None:
    """As it was typed, or as a run keeps it; also the number of agents."""
    same = [{"params": {"harm": -2}}, {"params": {"harm": "-2.0"}, "num_agents": 2}]
    runs = [
        write_run(tmp_path / str(number), "coins", (10.0, 12.0), reward=reward, rules="c01", provenance=asked)
        for number, (reward, asked) in enumerate(zip(("common", "individual"), same, strict=True))
    ]
    rows = [row for row in records(report_of(*runs), "own_and_common") if row["column"] == "common - individual"]
    assert [row["game"] for row in rows] == ["coins"]


@pytest.mark.parametrize(
    ("name", "param", "value", "usual"),
    [
        ("gift_refinement", "becomes", ["cut", "fine", "fine"], True),
        ("gift_refinement", "becomes", ["fine", "fine", "fine"], False),
        ("gift_refinement", "yields", [3, 3, 1], True),
        ("gift_refinement", "yields", [3, 3, 2], False),
        ("coins", "harm", "much", False),
        ("coins", "harms", -2, False),
    ],
)
def test_which_values_a_game_has_anyway(name: str, param: str, value: Any, usual: bool) -> None:
    assert is_usual(name, "", param, value) is usual


def test_games_that_are_variants_in_measurements_of_speed_are_in_no_command() -> None:
    speeds = tuple(SpeedRow(game, 2, False, "tokens", 1, 5.0, 4.0, 6.0, 3, "cpu") for game in ("coins+meltingpot", "pd_arena"))
    contents = contents_of(Evidence(speeds=speeds), False)
    assert contents.names == ("pd_arena", "coins+meltingpot")
    assert contents.plain_names == ("pd_arena",)
    assert "coins" not in " ".join(speed(contents).fill)


def test_runs_of_other_rules_are_noted_and_never_pooled(tmp_path: Path) -> None:
    runs = [write_run(tmp_path / rules, "coins", (10.0, 12.0), reward="common", rules=rules) for rules in ("c01", "old")]
    write_diagram(tmp_path / "d", "harvest_open", dict.fromkeys(("A", "B", "fear", "greed"), (1.0, 0.5, 1.5)), "dilemma")
    report = report_of(*runs, tmp_path / "d")
    assert [note for note in report.notes if "other rules" in note] == [
        "the runs of coins, rules old, 2 agents are of other rules (old) than the game has now (c01)",
        "the diagram of harvest_open is of other rules (4a7) than the game has now (new)",
    ]


CONTRASTS = dict.fromkeys(("A", "B", "fear", "greed"), (1.0, 0.5, 1.5))


def test_a_diagram_of_another_form_of_a_game_does_not_pass_for_the_game(tmp_path: Path) -> None:
    """Of a variant, another number of agents, another map that a run tells of, and rules that are gone."""
    write_run(tmp_path / "run", "coins", (10.0, 12.0), rules="map1", provenance={"map": "maps/large.txt"})
    forms = {"c02": ("variant socialjax", None), "ab12cd34": ("rules ab12cd, 3 agents", 3), "map1": ("map large.txt", None)}
    for rules, (_, agents) in forms.items():
        write_diagram(tmp_path / f"d_{rules}", "coins", CONTRASTS, "dilemma", caution="Zeros.", rules=rules, agents=agents)
    report = report_of(tmp_path)
    section = report.page.split("## Schelling")[1].split("## Cross-play")[0]
    for rules, (label, _) in forms.items():
        row = next(row for row in section.splitlines() if row.startswith(f"| coins, {label} |"))
        published = "fear, called a prisoner's dilemma (a prisoner's dilemma has greed as well)" if rules == "c02" else ""
        assert f"| dilemma, fear and greed | {published} | 5 training seeds |" in row
        assert f"coins, {label}: Zeros." in section
    assert "sjdsl schelling coins --cooperators runs/rewards/cells/coins_reward-common" in section
    assert {row["hash"]: row["published_shape"] for row in records(report, "schelling")} == {"c02": "fear", "ab12cd34": "", "map1": ""}
    assert [note for note in report.notes if "the diagram" in note] == [
        "the diagram of coins is of other rules (ab12cd34) than the game has now (c01)"
    ]

    write_diagram(tmp_path / "d", "coins", CONTRASTS, "dilemma")
    section = report_of(tmp_path).page.split("## Schelling")[1].split("## Cross-play")[0]
    assert [row.split(" | ")[0] for row in section.splitlines() if row.startswith("| coins")][:2] == [
        "| coins, variant socialjax",
        "| coins",
    ]
    assert "sjdsl schelling" not in section


def test_a_cross_play_of_another_form_of_a_game_does_not_pass_for_the_game(tmp_path: Path) -> None:
    for rules in ("c02", "ab12cd34"):
        write_cross_play(tmp_path / rules, "coins", {"stay": (0.0, None, None)}, rules)
    report = report_of(tmp_path)
    section = report.page.split("## Cross-play")[1].split("## Speed")[0]
    assert "| coins, variant socialjax | 2 x stay |" in section
    assert "| coins, rules ab12cd, 2 agents | 2 x stay |" in section
    assert "sjdsl crossplay coins" in section
    assert [note for note in report.notes if "cross-play" in note] == [
        "the cross-play of coins is of other rules (ab12cd34) than the game has now (c01)"
    ]
    write_cross_play(tmp_path / "own", "coins", {"stay": (0.0, None, None)})
    assert "sjdsl crossplay" not in report_of(tmp_path).page


def test_a_diagram_of_scripted_policies_leaves_the_command_of_the_trained_one(tmp_path: Path) -> None:
    write_diagram(tmp_path / "scripted", "coins", CONTRASTS, "dilemma", scripted=True)
    section = report_of(tmp_path).page.split("## Schelling")[1].split("## Cross-play")[0]
    assert "| coins | `cooperator` | `defector` |" in section
    assert "| coins, variant socialjax |  |  |  |  |  |  |  | fear, called a prisoner's dilemma" in section
    assert "its command is below" in section
    assert "sjdsl schelling coins --cooperators runs/rewards/cells/coins_reward-common" in section
    write_diagram(tmp_path / "trained", "coins", CONTRASTS, "dilemma")
    first, second = [row for row in report_of(tmp_path).page.splitlines() if row.startswith("| coins | `") and "dilemma, " in row]
    assert "`runs/coins_common`" in first
    assert "called a" not in first + second
    assert "sjdsl schelling" not in report_of(tmp_path).page


def test_a_verdict_on_samples_without_spread_says_so(tmp_path: Path) -> None:
    write_diagram(
        tmp_path,
        "coins",
        dict.fromkeys(("A", "B", "fear", "greed"), (1.0, 1.0, 1.0)),
        "dilemma",
        caution="This rests on zeros.",
        rules="c02",
    )
    page = report_of(tmp_path).page
    assert "coins, variant socialjax: This rests on zeros." in page
    assert "| 1 [1, 1] | dilemma, fear and greed | fear, called a prisoner's dilemma" in page


def test_the_suite_is_shown_whole_where_nothing_is_known_and_says_what_finds_it() -> None:
    report = make_report(Evidence(), "sjdsl report", whole_suite=True)
    assert line(report, "pd_arena, variant socialjax | ours") == ["pd_arena, variant socialjax", "ours", *[""] * 7]
    assert line(report, " | published", which=8)[2] == "144 ± 40"
    called = [shlex.split(row) for row in report.page.splitlines() if row.startswith("sjdsl ")]
    assert {call[1] for call in called} == {"sweep", "train", "schelling", "crossplay", "bench"}
    above = click.Context(commands, info_name="sjdsl")
    for _, name, *arguments in called:
        command = commands.get_command(above, name)
        assert command is not None, name
        command.make_context(name, arguments, parent=above)


def test_a_report_of_nothing_is_short() -> None:
    report = make_report(Evidence(), "sjdsl report")
    assert len(report.page) < 6000
    assert not report.pictures


def test_the_variant_that_the_paper_played_is_another_in_one_game(tmp_path: Path) -> None:
    """Its findings, tables and commands are of that variant; runs under the rules of the other games have nothing published beside them."""
    rewards = {"individual": (100.0, 101.0, 102.0), "common": (500.0, 510.0, 505.0)}
    for variant, rules in (("socialjax", "b52"), ("socialjax+automatic", "a17")):
        for reward, returns in rewards.items():
            asked = {"provenance": {"variant": variant}, "reward": reward}
            write_run(tmp_path / f"{variant}_{reward}", "gift_refinement", returns, rules=rules, **asked)
    write_diagram(tmp_path / "diagram", "gift_refinement", CONTRASTS, "dilemma", rules="a17", agents=5)
    report = report_of(tmp_path, whole_suite=True)
    verdicts = {(row["claim"], row["game"]): row["verdict"] for row in records(report, "findings")}
    assert verdicts["common reward earns more than individual reward", "gift_refinement"] == "holds"
    assert [verdict for (claim, game), verdict in verdicts.items() if "diagram" in claim and game == "gift_refinement"] == ["holds"]
    published = {row["game"] for row in records(report, "exchange") if row["published"] == "505"}
    assert published == {"gift_refinement, variant socialjax+automatic"}
    assert "| dilemma, fear and greed | fear, called a stag hunt | 5 training seeds |" in report.page
    page = make_report(Evidence(), "sjdsl report", whole_suite=True).page
    for call in (row for row in page.splitlines() if row.startswith(("sjdsl sweep", "sjdsl schelling", "sjdsl crossplay"))):
        variant = "socialjax+automatic" if "gift_refinement" in call else "socialjax"
        assert f"--variant {variant} " in call
        assert call.endswith(f"_{variant}")

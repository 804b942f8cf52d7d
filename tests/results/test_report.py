"""A report of results: what its tables say, where it may be written, and that no result is lost."""

import csv
from collections.abc import Callable
from pathlib import Path

import pytest
from report_folders import read, write_diagram, write_everything, write_run

from sjdsl.cli import run
from sjdsl.results import ResultsError, write_report
from sjdsl.results.page import Section, page_text
from sjdsl.results.sections import chosen_games, held_out, returns, trials

COMMAND = "sjdsl report runs"
CONTRASTS = dict.fromkeys(("A", "B", "fear", "greed"), (1.0, 0.5, 1.5))


def texts(section: Section, table: int = 0) -> list[list[str]]:
    """Returns the cells of a table as the page has them."""
    lines = page_text("", [section], [], []).split("\n\n")
    rows = [part for part in lines if part.startswith("| ")][table].splitlines()[2:]
    return [[cell.strip() for cell in row.strip("|").split(" | ")] for row in rows]


def test_a_cell_is_the_mean_over_seeds_with_its_interval(tmp_path: Path) -> None:
    found = returns(
        read(write_run(tmp_path / "run", "coins", (150.0, 160.0, 155.0), reward="common")).frame
    )
    (cell,) = found.tables[0].records
    # Student's t at 97.5 % with two degrees of freedom, from a printed table: 4.303; the standard error of 150, 160, 155 is 5 / sqrt(3).
    assert cell["collective return mean"] == 155
    assert abs(cell["collective return high"] - (155 + 4.303 * 5 / 3**0.5)) < 1e-2
    assert texts(found) == [
        ["coins", "IPPO, common", "155 [143, 167]", "3 seeds, 400 steps, unnamed CPU"]
    ]


def test_a_game_with_trials_has_its_return_in_each(tmp_path: Path) -> None:
    measures = {
        "collective return of trial 0": (40.0, 42.0),
        "collective return of trial 1": (60.0, 60.0),
    }
    write_run(tmp_path / "run", "coins", (100.0, 102.0), measures=measures)
    write_run(tmp_path / "other", "harvest_open", (10.0, 12.0))  # a game without trials
    rows = texts(trials(read(tmp_path).frame))
    assert [row[:3] for row in rows] == [
        ["coins", "IPPO, individual", "0"],
        ["coins", "IPPO, individual", "1"],
    ]
    # Student's t with one degree of freedom is 12.71, from a printed table; the standard error 1.
    assert [row[3] for row in rows] == ["41 [28, 54]", "60 [60, 60]"]
    assert trials(read(tmp_path / "other").frame).tables == ()


TRIAL = "collective return of trial 0"
RULES = {"rules": "0c"}  # a hash


def test_held_out_tasks_stand_beside_training_tasks(tmp_path: Path) -> None:
    late = [{"collective return": 90.0, TRIAL: 8.0}, {"collective return": 98.0, TRIAL: 9.0}]
    write_run(
        tmp_path / "run",
        "orchard",
        (100.0, 106.0),
        tasks={"tasks": "training", "split": ""},
        measures={TRIAL: (10.0, 11.0)},
        held_out={"late": late},
        **RULES,
    )
    write_run(tmp_path / "other", "harvest_open", (10.0, 12.0))  # a game without tasks
    frame = read(tmp_path).frame
    (row,) = texts(held_out(frame))
    # 100 - 90 and 106 - 98; Student's t with one degree of freedom is 12.71, the standard error 1.
    last = "9 [-4, 22]"
    assert row[:3] == ["orchard", "IPPO, individual", "late"]
    assert row[3].startswith("103 ")
    assert row[4].startswith("94 ")
    assert row[5] == last
    assert [line[2] for line in texts(trials(frame))] == ["0", "0, held out late"]
    write_report([tmp_path], tmp_path / "out", COMMAND)
    again = read(tmp_path / "out" / "data").frame
    assert texts(held_out(again)) == [row]


def test_runs_on_other_tasks_are_never_averaged(tmp_path: Path) -> None:
    """Their rules, settings and seeds are the same."""
    sides = {
        "": {"tasks": "training", "split": ""},
        ", tasks all": {"tasks": "all", "split": ""},
        ", tasks held_out late": {"tasks": "held_out", "split": "late"},
        ", tasks held_out rich": {"tasks": "held_out", "split": "rich"},
        ", tasks hue=red pay[red]=3": {"tasks": {"hue": "red", "pay[red]": 3}, "split": ""},
    }
    for number, tasks in enumerate(sides.values()):
        earned = (10.0 * number, 10.0 * number)
        write_run(tmp_path / f"run_{number}", "orchard", earned, tasks=tasks, **RULES)
        write_run(tmp_path / f"more_{number}", "orchard", earned, first=2, tasks=tasks, **RULES)
    frame = read(tmp_path).frame
    rows = {row[0]: row[2] for row in texts(returns(frame))}
    expected = {}
    for number, name in enumerate(sides):
        expected[f"orchard{name}"] = f"{10 * number} [{10 * number}, {10 * number}]"
    assert rows == expected
    assert frame.run.nunique() == len(sides)


def test_ways_of_training_are_named_by_the_values_in_which_they_differ(tmp_path: Path) -> None:
    write_run(tmp_path / "usual", "coins", (10.0, 12.0))
    write_run(tmp_path / "fast", "coins", (10.0, 12.0), learning_rate=0.01, init_from=str(tmp_path))
    write_run(tmp_path / "deep", "coins", (10.0, 12.0), network="cnn", convolution_sides=[3, 3])
    assert {row[1] for row in texts(returns(read(tmp_path).frame))} == {
        "IPPO, individual (init_from none, learning_rate 0.0005, network cnn)",
        "IPPO, individual (init_from a policy, learning_rate 0.01, network mlp)",
        "IPPO, individual (init_from none, learning_rate 0.0005, network mlp)",
    }


@pytest.mark.parametrize(
    ("ways", "chosen"),
    [
        (["abcd", "abc", "abc"], "abc"),  # one game more in one way takes no comparison away
        (["abcd", "abcd", "ab", "ab", "ab", "ab"], "ab"),  # twelve pairs rather than eight
        (["abcd", "ab"], "ab"),  # two ways rather than one
        (["abcd"], "abcd"),
        (["ab", "ac"], "ab"),  # as good as each other: the first
        (["ac", "ab"], "ab"),
        (["abc", "bcd"], "bc"),
        (["a", "b"], ""),
        ([], ""),
    ],
)
def test_games_in_which_most_can_be_compared(ways: list[str], chosen: str) -> None:
    for order in (ways, ways[::-1]):
        scores = {
            game: {f"way {number}": None for number, games in enumerate(order) if game in games}
            for game in "abcd"
        }
        assert chosen_games(scores) == list(chosen)


# Where a report goes.


@pytest.fixture
def no_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pictures cost more than all else here, and are drawn in another test."""

    def empty(sections: list[Section]) -> dict[str, bytes]:
        return {
            f"figures/{picture.name}.png": b""
            for section in sections
            for picture in section.pictures
        }

    monkeypatch.setattr("sjdsl.results.report.draw_pictures", empty)


def files(folder: Path) -> dict[str, bytes]:
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file()
    }


def test_the_files_of_a_report(tmp_path: Path) -> None:
    write_run(tmp_path / "runs/a", "coins", (3.0, 5.0))
    write_report([tmp_path / "runs"], tmp_path / "out", COMMAND)
    found = files(tmp_path / "out")
    assert {
        "report.md",
        "tables/returns.csv",
        "data/results.csv",
        "data/curves.csv",
    } <= found.keys()
    assert found["figures/curves_coins.png"][:4] == b"\x89PNG"
    assert found["figures/curves_coins.svg"][:5] == b"<?xml"
    (row,) = csv.DictReader(found["tables/returns.csv"].decode().splitlines())
    assert (row["game"], row["collective return mean"], row["collective return seeds"]) == (
        "coins",
        "4",
        "2",
    )
    assert b"(figures/curves_coins.png)" in found["report.md"]


@pytest.mark.usefixtures("no_pictures")
def test_everything(tmp_path: Path, golden: Callable[[Path, str], None]) -> None:
    """What the page says of runs, sweeps, diagrams and cross-play of many kinds."""
    write_everything(tmp_path / "runs")
    write_report([tmp_path / "runs"], tmp_path / "out", COMMAND)
    golden(
        Path(__file__).with_name("report.txt"),
        (tmp_path / "out/report.md").read_text().replace(f"{tmp_path}/", ""),
    )


@pytest.mark.usefixtures("no_pictures")
def test_a_report_is_made_again_from_its_own_data(tmp_path: Path) -> None:
    write_run(tmp_path / "runs/a", "coins", (3.0, 5.0))
    write_diagram(tmp_path / "runs/d", "coins", CONTRASTS, "dilemma")
    out = tmp_path / "out"
    write_report([tmp_path / "runs"], out, COMMAND)
    write_report([out / "data"], tmp_path / "again", COMMAND)
    assert files(tmp_path / "again") == files(out)
    write_report(
        [out / "data", write_run(tmp_path / "b", "coins", (4.0,), first=2)],
        tmp_path / "more",
        COMMAND,
    )
    assert len((tmp_path / "more/data/results.csv").read_text().splitlines()) == 5


@pytest.mark.usefixtures("no_pictures")
def test_a_place_with_other_files_is_refused(tmp_path: Path) -> None:
    write_run(tmp_path / "runs/a", "coins", (3.0, 5.0))
    out = tmp_path / "out"
    out.mkdir()
    (out / "thesis.tex").write_text("mine")
    with pytest.raises(ResultsError, match="is not empty; name another place"):
        write_report([tmp_path / "runs"], out, COMMAND)
    assert [*files(out)] == ["thesis.tex"]
    with pytest.raises(ResultsError, match="is a file, expected a folder"):
        write_report([tmp_path / "runs"], out / "thesis.tex", COMMAND)


@pytest.mark.usefixtures("no_pictures")
def test_the_command(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    write_run(Path("runs/a"), "coins", (3.0, 5.0))
    write_run(Path("runs/b"), "coins", (3.0,), status="running", reward="common")
    write_run(Path("runs/c"), "pd_arena", (3.0, 5.0), reward="common")
    assert run(["report", "runs", "-o", "out"]) == 0
    told = capsys.readouterr()
    assert "out/report.md  3 runs, 5 seeds, 1 table, 1 picture" in told.out
    assert "note: `runs/b` isn't finished" in told.err
    assert run(["report", "runs", "-o", "out"]) == 1
    assert "error: `out` is not empty; name another place" in capsys.readouterr().err
    assert run(["report", "-o", "out"]) == 2
